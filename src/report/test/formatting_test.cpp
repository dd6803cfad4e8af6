#include "takt/report/drawing/formatting.hpp"

#include <gtest/gtest.h>

namespace takt::report {
namespace formatting_test {

using namespace std::chrono_literals;
using wire::Function;

TEST(Formatting, PeriodsWithTheirPhase) {
    const Texts english(text::Language::english);
    EXPECT_EQ(turn_text(english, 1s, 0ms), "1 s");
    EXPECT_EQ(turn_text(english, 1s, 300ms), "1 s +300 ms");
    EXPECT_EQ(turn_text(Texts(text::Language::russian), 20ms, 2500us), "20.0 мс +2.5 мс");
}

TEST(Formatting, MicrosecondsAreRoundedUp) {
    EXPECT_EQ(whole_microseconds(0ns), 0);
    EXPECT_EQ(whole_microseconds(1ns), 1);
    EXPECT_EQ(whole_microseconds(1000ns), 1);
    EXPECT_EQ(whole_microseconds(1001ns), 2);
}

TEST(Formatting, AreasAndFunctions) {
    EXPECT_EQ(area_word(wire::Area::coil), "coils");
    EXPECT_EQ(area_word(wire::Area::discrete_input), "discrete");
    EXPECT_EQ(area_word(wire::Area::input_register), "input");
    EXPECT_EQ(area_word(wire::Area::holding_register), "holding");
    EXPECT_EQ(function_text(Function::write_multiple_registers), "0x10");
    EXPECT_EQ(function_text(Function::read_coils), "0x01");
}

TEST(Formatting, Ranges) {
    EXPECT_EQ(range_text({7, 7}), "7");
    EXPECT_EQ(range_text({0, 65535}), "0..65535");
}

plan::Request request(std::optional<Function> read, std::optional<Function> write, std::uint16_t start,
                      std::uint16_t quantity) {
    plan::Request made;
    made.read = read;
    made.write = write;
    made.start = start;
    made.quantity = quantity;
    return made;
}

TEST(Formatting, Requests) {
    EXPECT_EQ(request_text(request(Function::read_holding_registers, {}, 500, 2)), "0x03 500..501");
    EXPECT_EQ(request_text(request(Function::read_coils, {}, 7, 1)), "0x01 7");
    EXPECT_EQ(request_text(request({}, Function::write_single_coil, 7, 1)), "0x05 7");
    EXPECT_EQ(
        request_text(request(Function::read_holding_registers, Function::write_multiple_registers, 0, 2)),
        "0x03+0x10 0..1");
}

TEST(Formatting, RequestsThatReadAndWriteAtOnce) {
    auto both =
        request(Function::read_write_multiple_registers, Function::read_write_multiple_registers, 10, 4);
    both.write_start = 20;
    both.write_quantity = 1;
    EXPECT_EQ(request_text(both), "0x17 10..13 < 20");
    auto modify = request({}, Function::write_single_register, 5, 1);
    modify.read_modify_write = true;
    EXPECT_EQ(request_text(modify), "0x03+0x06 5");
}

TEST(Formatting, Items) {
    const struct {
        wire::Area area;
        std::uint32_t address;
        const char* text;
    } cases[] = {{wire::Area::coil, 0, "coils 0"},
                 {wire::Area::discrete_input, 7, "discrete 7"},
                 {wire::Area::input_register, 500, "input 500"},
                 {wire::Area::holding_register, 65535, "holding 65535"}};
    for (const auto& [area, address, text] : cases) EXPECT_EQ(item_text(area, address), text);
}

}  // namespace formatting_test
}  // namespace takt::report
