#include "takt/base/result.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "takt/base/data_type.hpp"
#include "takt/base/time.hpp"

namespace takt {
namespace result_test {

Result<int> half(int value) {
    if (value % 2 != 0) return fail(Code::malformed, "odd", value);
    return value / 2;
}

Result<int> quarter(int value) {
    TAKT_TRY(const int first, half(value));
    TAKT_TRY(const int second, half(first));
    return second;
}

TEST(Result, TryHandsTheFirstErrorOn) {
    EXPECT_EQ(quarter(12).value(), 3);
    EXPECT_EQ(quarter(6).error(), (Error{Code::malformed, "odd", {3, 0, 0}}));
}

TEST(Result, EveryCodeHasANameOfItsOwn) {
    std::set<std::string_view> names;
    for (int code : {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 100, 101, 102, 103, 104, 200, 201, 202}) {
        const auto text = name(static_cast<Code>(code));
        EXPECT_NE(text, "unknown") << code;
        EXPECT_TRUE(names.insert(text).second) << text;
    }
}

TEST(DataType, NamesComeBack) {
    for (int i = 0; i <= static_cast<int>(DataType::string); ++i) {
        const auto type = static_cast<DataType>(i);
        EXPECT_EQ(data_type(name(type)), type);
    }
    EXPECT_EQ(data_type("int"), DataType::int16);
    EXPECT_EQ(data_type("real"), DataType::float32);
    EXPECT_EQ(data_type("word"), std::nullopt);
}

TEST(Time, AfterDoesNotOverflow) {
    EXPECT_EQ(after(kNever, std::chrono::seconds(1)), kNever);
    EXPECT_EQ(after(Instant{}, std::chrono::seconds(1)), Instant{} + std::chrono::seconds(1));
}

}  // namespace result_test
}  // namespace takt
