#include "takt/file/json.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>

#include "takt/base/ascii.hpp"

namespace takt::file {
namespace json_test {

TEST(Json, IsWrittenInTheOrderItWasMade) {
    auto inner = Json::array();
    inner.push_back(1);
    inner.push_back("two");
    inner.push_back({});
    auto object = Json::object();
    object.set("z", true);
    object.set("a", std::move(inner));
    object.set("m", Json::object());
    EXPECT_EQ(object.dump(), R"({"z":true,"a":[1,"two",null],"m":{}})");
    object.set("z", 2);
    EXPECT_EQ(object.dump(2),
              "{\n  \"z\": 2,\n  \"a\": [\n    1,\n    \"two\",\n    null\n  ],\n  \"m\": {}\n}");
    EXPECT_EQ(*object.find("z"), Json(2));
    EXPECT_EQ(object.find("y"), nullptr);
    EXPECT_EQ(Json(1).find("y"), nullptr);
}

TEST(Json, WritesScalars) {
    const std::pair<Json, std::string_view> cases[] = {
        {{}, "null"},
        {false, "false"},
        {std::numeric_limits<std::int64_t>::min(), "-9223372036854775808"},
        {std::numeric_limits<std::uint64_t>::max(), "18446744073709551615"},
        {std::uint8_t{200}, "200"},
        {0.1, "0.1"},
        {0.1F, "0.1"},
        {11.661829, "11.661829"},
        {11.661829F, "11.661829"},
        {1e15, "1000000000000000.0"},
        {1e16, "1e+16"},
        {1e-5, "1e-05"},
        {5e-324, "5e-324"},
        {16777216.0F, "16777216.0"},
        {1e300, "1e+300"},
        {-0.0, "-0.0"},
        {1.0, "1.0"},
        {std::nan(""), "null"},
        {-std::numeric_limits<float>::infinity(), "null"},
        {"a\"\\\n\x01 ё", R"("a\"\\\n\u0001 ё")"},
        {std::string("a\0b", 3), R"("a\u0000b")"},
        {"\xFF\xC0", "\"\xEF\xBF\xBD\xEF\xBF\xBD\""},
    };
    for (const auto& [json, text] : cases) EXPECT_EQ(json.dump(), text);
}

TEST(Json, ReadsWithLimits) {
    EXPECT_EQ(Json::parse(R"( {"b":[1,-2,0.5,"x",null,true],"a":{}} )")->dump(),
              R"({"b":[1,-2,0.5,"x",null,true],"a":{}})");
    EXPECT_EQ(Json::parse("18446744073709551615")->value(),
              Json::Value(std::uint64_t{18446744073709551615U}));
    constexpr std::string_view kRefused[] = {
        "",      "{",         "[1,]", "{\"a\":1,\"a\":2}", "1 2",     "nul",         "\"\xFF\"", "[1e999]",
        "01",    "{\"a\" 1}", "'a'",  "\"\x01\"",          "[1] //c", "\"\\ud800\"", "NaN",      "{a:1}",
        "[1 2]", "\""};
    for (const auto text : kRefused) {
        const auto json = Json::parse(text);
        ASSERT_FALSE(json.has_value()) << text;
        EXPECT_EQ(json.error().code, Code::syntax) << text;
        EXPECT_FALSE(json.error().subject.empty()) << text;
    }
    EXPECT_EQ(Json::parse(std::string_view("{}\0x", 4)).error(), (Error{Code::syntax, "NUL", {2}}));
    EXPECT_EQ(Json::parse("[1]", 2).error(), (Error{Code::too_long, "", {3, 2}}));
    EXPECT_EQ(Json::parse("[1,x]").error().numbers[0], 4);
    const auto nested = [](std::size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); };
    EXPECT_TRUE(Json::parse(nested(Json::kMaxDepth)).has_value());
    EXPECT_EQ(Json::parse(nested(Json::kMaxDepth + 1)).error().subject.view(), "too deep");
    EXPECT_EQ(Json::parse(std::string(1'000'000, '[')).error().subject.view(), "too deep");
}

TEST(Json, ManyKeysAreReadInGoodTime) {
    std::string text = "{";
    for (int i = 0; i < 80'000; ++i) text += "\"k" + std::to_string(i) + "\":0,";
    EXPECT_TRUE(Json::parse(text + "\"k\":0}").has_value());
    EXPECT_FALSE(Json::parse(text + "\"k7\":0}").has_value());
}

Json any_json(int depth) {
    switch (*rc::gen::inRange(0, depth > 0 ? 8 : 6)) {
        case 0: return {};
        case 1: return *rc::gen::arbitrary<bool>();
        case 2: return -1 - *rc::gen::nonNegative<std::int64_t>();
        case 3: return *rc::gen::arbitrary<std::uint64_t>();
        case 4: return *rc::gen::arbitrary<double>();
        case 5: return *rc::gen::container<std::string>(rc::gen::inRange<char>(0, 127));
        case 6: {
            auto list = Json::array();
            for (int i = *rc::gen::inRange(0, 4); i > 0; --i) list.push_back(any_json(depth - 1));
            return list;
        }
        default: {
            auto object = Json::object();
            for (int i = *rc::gen::inRange(0, 4); i > 0; --i)
                object.set("k" + std::to_string(i), any_json(depth - 1));
            return object;
        }
    }
}

TEST(Json, HoldsNothingThatATerminalObeys) {
    const Json json("\x1B[2J \x7F \xC2\x9B \xE2\x80\xAE \xE2\x80\xA8 \xFF уровень");
    EXPECT_EQ(json.dump(), R"("\u001b[2J \u007f \u009b \u202e \u2028 )"
                           "\xEF\xBF\xBD уровень\"");
    EXPECT_EQ(std::get<std::string>(Json::parse(json.dump())->value()),
              "\x1B[2J \x7F \xC2\x9B \xE2\x80\xAE \xE2\x80\xA8 \xEF\xBF\xBD уровень");
}

RC_GTEST_PROP(Json, ComesBackAsItWas, ()) {
    const auto json = any_json(4);
    RC_ASSERT(Json::parse(json.dump()).value() == json);
    RC_ASSERT(Json::parse(json.dump(4)).value() == json);
}

RC_GTEST_PROP(Json, AnyTextIsReadOrRefused, ()) {
    const auto text = *rc::gen::container<std::string>(
        rc::gen::elementOf(std::string("{}[]:,\"\\u01e+-. truefalsn\xC3\xA9\n")));
    if (const auto json = Json::parse(text)) RC_ASSERT(Json::parse(json->dump()).value() == *json);
}

RC_GTEST_PROP(Json, DoublesHaveTheFewestDigits, (int digits, int exponent)) {
    const double number =
        std::strtod((std::to_string(digits) + 'e' + std::to_string(exponent % 12)).c_str(), nullptr);
    std::array<char, 64> shortest{};
    const auto* const end =
        std::to_chars(shortest.begin(), shortest.end(), number, std::chars_format::scientific).ptr;
    const auto significant = [](std::string_view text) {
        std::string found;
        for (const char c : text.substr(0, text.find('e')))
            if (is_digit(c)) found += c;
        found.erase(0, found.find_first_not_of('0'));
        found.erase(found.find_last_not_of('0') + 1);
        return found;
    };
    RC_ASSERT(significant(Json(number).dump()) == significant({shortest.begin(), end}));
}

RC_GTEST_PROP(Json, FloatsAreShort, (float number)) {
    RC_PRE(std::isfinite(number));
    const Json json(number);
    RC_ASSERT(static_cast<float>(std::get<double>(json.value())) == number);
}

}  // namespace json_test
}  // namespace takt::file
