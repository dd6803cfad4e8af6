#include "takt/report/drawing/value_json.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "sample.hpp"

namespace takt::report {
namespace value_json_test {

using namespace test;

TEST(ValueJson, EveryKindOfValue) {
    const struct {
        DataType type;
        bool scaled;
        value::Value value;
        const char* json;
    } cases[] = {
        {DataType::int16, false, {}, "null"},
        {DataType::boolean, false, true, "true"},
        {DataType::int16, false, std::int64_t{-32768}, "-32768"},
        {DataType::int64, false, std::numeric_limits<std::int64_t>::min(), "-9223372036854775808"},
        {DataType::uint64, false, std::numeric_limits<std::uint64_t>::max(), "18446744073709551615"},
        {DataType::float32, false, double{0.1F}, "0.1"},
        {DataType::float32, true, double{0.1F}, "0.10000000149011612"},
        {DataType::float64, false, 0.1, "0.1"},
        {DataType::float64, false, std::numeric_limits<double>::quiet_NaN(), "null"},
        {DataType::float32, false, std::numeric_limits<double>::infinity(), "null"},
        {DataType::string, false, std::string("Котёл \"1\"\n"), R"("Котёл \"1\"\n")"},
        {DataType::string, false, std::string("\xFF"), "\"\xEF\xBF\xBD\""},
    };
    for (const auto& c : cases) EXPECT_EQ(to_json(c.type, c.scaled, c.value).dump(), c.json);
}

TEST(ValueJson, ErrorsKeepTheirCodeInEveryLanguage) {
    const auto error = fail(Code::cannot_open, "/dev/ttyS1", 2).error();
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto json = error_json(texts, error);
        EXPECT_JSON(at(json, "code"), name(Code::cannot_open));
        EXPECT_JSON(at(json, "text"), texts.describe(error));
    }
}

}  // namespace value_json_test
}  // namespace takt::report
