#include "takt/endpoint/answer.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <string>

#include "takt/value/text.hpp"

namespace takt::endpoint {
namespace answer_test {

Bytes bytes_of(const std::string& text) {
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::string measured_text(const std::optional<Measurements>& found) {
    if (!found) return "-";
    std::string all;
    for (const auto& [name, value] : *found) {
        all += all.empty() ? "" : " ";
        all += std::string(name) + "=";
        if (const auto* const text = std::get_if<std::string>(&value)) all += "'" + *text + "'";
        if (const auto* const whole = std::get_if<std::int64_t>(&value)) all += std::to_string(*whole);
        if (const auto* const hex = std::get_if<std::uint64_t>(&value)) all += "0x" + std::to_string(*hex);
        if (const auto* const real = std::get_if<double>(&value))
            all += value::format(DataType::float64, false, *real) + "f";
    }
    return all;
}

TEST(Match, Rows) {
    struct Row {
        const char* pattern;
        std::string text;
        const char* expected;
    };
    const Row rows[] = {
        {"{w} kg", "12.5 kg", "w=12.5f"},
        {"{w} kg", "  -12 kg", "w=-12"},
        {"{w} kg", "-  1.5 kg", "w=-1.5f"},
        {"{w} kg", "+.5 kg", "w=0.5f"},
        {"{w} kg", "5. kg", "w=5f"},
        {"{w} kg", "1e3 kg", "w=1000f"},
        {"{w} kg", "1e kg", "-"},
        {"{w} kg", "12.5 lb", "-"},
        {"{w} kg", "12.5 kg ", "-"},
        {"{w} kg", "------ kg", "-"},
        {"{w} kg", "nan kg", "-"},
        {"{w} kg", ". kg", "-"},
        {"{w} kg", "1.2.3 kg", "-"},
        {"{w} kg", "1 2 kg", "-"},
        {"{w} kg", "", "-"},
        {"{w}", "9223372036854775807", "w=9223372036854775807"},
        {"{w}", "9223372036854775808", "w=9223372036854775808f"},
        {"{w}", "1e999", "-"},
        {"{w}", std::string(100, '9'), "-"},
        {"{a:hex}!", "fF!", "a=0x255"},
        {"{a:hex}", "11111111111111111", "-"},
        {"{a:text};{b}", " x y ;2", "a='x y' b=2"},
        {"{*}temp={value}{*}", "1\ntemp=7", "-"},
        {"{*}temp={value}\n{*}", "a temp=7\nx", "value=7"},
        {"{*},{b}", "x,y,3", "-"},
        {"", "", ""},
        {"", "x", "-"},
    };
    for (const auto& [pattern, text, expected] : rows) {
        const auto parsed = model::parse_template(pattern);
        if (!parsed) {
            EXPECT_STREQ(expected, "-") << pattern;
            continue;
        }
        EXPECT_EQ(measured_text(match(*parsed, text)), expected) << pattern << " <- " << text;
    }
}

model::AnswerFormat binary(model::Checksum checksum) {
    model::AnswerFormat format;
    format.length = 9;
    format.begins = "\x02";
    format.checksum = checksum;
    format.fields = {{.name = "f",
                      .offset = 1,
                      .bytes = 4,
                      .type = DataType::float32,
                      .order = {.high_byte_first = true, .high_register_first = true}},
                     {.name = "s", .offset = 5, .bytes = 1, .is_signed = true}};
    return format;
}

std::string frame(std::initializer_list<int> bytes) {
    std::string text;
    for (const int byte : bytes) text += static_cast<char>(byte);
    return text;
}

TEST(Answer, BinaryWithItsChecksum) {
    struct Row {
        model::Checksum checksum;
        std::string frame;
        const char* expected;
    };
    const Row rows[] = {
        {model::Checksum::none, frame({2, 0x3F, 0x80, 0, 0, 0xFE, 7, 7, 7}), "f=1f s=-2"},
        {model::Checksum::none, frame({3, 0x3F, 0x80, 0, 0, 0xFE, 7, 7, 7}), "-"},
        {model::Checksum::none, frame({2, 0x7F, 0x80, 0, 0, 0xFE, 7, 7, 7}), "-"},
        {model::Checksum::none, frame({2, 0x3F, 0x80, 0, 0, 0xFE, 7, 7}), "-"},
        {model::Checksum::sum, frame({2, 0x3F, 0x80, 0, 0, 0xFE, 0, 0, 0xBF}), "f=1f s=-2"},
        {model::Checksum::sum, frame({2, 0x3F, 0x80, 0, 0, 0xFE, 0, 0, 0xBE}), "-"},
        {model::Checksum::exclusive_or, frame({2, 0x3F, 0x80, 0, 0, 0xFE, 0, 0, 0x43}), "f=1f s=-2"},
        {model::Checksum::exclusive_or, frame({2, 0x3F, 0x80, 0, 0, 0xFF, 0, 0, 0x43}), "-"},
    };
    for (const auto& [checksum, answer, expected] : rows)
        EXPECT_EQ(measured_text(read_answer(binary(checksum), bytes_of(answer))), expected);
}

TEST(Answer, Crc16IsModbuss) {
    model::AnswerFormat format;
    format.length = 9;
    format.checksum = model::Checksum::crc16;
    format.fields = {{.name = "v", .offset = 3, .bytes = 2, .type = DataType::uint16, .order = {true, true}}};
    EXPECT_EQ(measured_text(read_answer(format, bytes_of(frame({1, 4, 4, 0, 2, 0, 3, 0x1A, 0x45})))),
              "v=0x2");
    EXPECT_EQ(measured_text(read_answer(format, bytes_of(frame({1, 4, 4, 0, 2, 0, 3, 0x1A, 0x44})))), "-");
}

TEST(Answer, WhereItStands) {
    model::AnswerFormat text;
    text.until = "\r\n";
    EXPECT_EQ(find_answer(text, bytes_of("12\r")).answer, 0u);
    EXPECT_EQ(find_answer(text, bytes_of("12\r\n3")).answer, 4u);
    const auto found = find_answer(binary(model::Checksum::none), bytes_of("xy\x02"
                                                                           "345678901"));
    EXPECT_EQ(found.skip, 2u);
    EXPECT_EQ(found.answer, 9u);
    EXPECT_EQ(find_answer(binary(model::Checksum::none), bytes_of("xy")).skip, 2u);
}

RC_GTEST_PROP(Answer, AnyBytesAreReadOrNot, (const std::vector<std::uint8_t>& answer)) {
    for (const auto checksum : {model::Checksum::none, model::Checksum::sum, model::Checksum::exclusive_or,
                                model::Checksum::crc16}) {
        const auto format = binary(checksum);
        const auto found = find_answer(format, answer);
        RC_ASSERT(found.skip + found.answer <= answer.size());
        (void)read_answer(format, answer);
    }
}

RC_GTEST_PROP(Answer, OneWrongByteOfACheckedAnswerIsNoValue, (std::uint8_t place, std::uint8_t change)) {
    auto answer = frame({2, 0x3F, 0x80, 0, 0, 0xFE, 0, 0, 0x43});
    RC_PRE(change != 0);
    answer[place % answer.size()] = static_cast<char>(answer[place % answer.size()] ^ change);
    RC_ASSERT(!read_answer(binary(model::Checksum::exclusive_or), bytes_of(answer)));
}

RC_GTEST_PROP(Match, ANumberInATemplateIsThatNumber, (std::int32_t number)) {
    const auto pattern = *model::parse_template("<{v}>");
    const auto found = match(pattern, "<" + std::to_string(number) + ">");
    RC_ASSERT(found.has_value());
    RC_ASSERT(std::get<std::int64_t>(found->front().value) == number);
}

RC_GTEST_PROP(Match, AnyTextAgainstAnyTemplate, (const std::string& text, const std::string& other)) {
    for (const char* pattern : {"{a}", "{*}=", "{a:text},{b:hex}{*", "{a:hex} {*}x{b}"})
        if (const auto parsed = model::parse_template(pattern)) {
            (void)match(*parsed, text);
            (void)match(*parsed, text + "=" + other);
        }
}

}  // namespace answer_test
}  // namespace takt::endpoint
