#include "devices/command_preview.hpp"

#include <gtest/gtest.h>

#include "running_host.hpp"
#include "takt/wire/frame_words.hpp"

namespace takt::web {
namespace command_preview_test {

using namespace test;

/// The frames of writing a value in a project with these variables, as hex.
std::vector<std::string> frames_of(const std::string& variables, const std::string& name,
                                   const value::Value& value, const std::string& device = "",
                                   bool* rounded = nullptr) {
    const RunningHost running(host::test::project_with(
        host::test::line_of("plant", host::test::device_of("Boiler", 1, variables, device))));
    const auto session = running.host->open_session({.events = false});
    const auto snapshot = (*session)->snapshot({.values = true, .statistics = true, .plan = true});
    const auto slot = snapshot->configuration->find(name);
    const auto shown = preview(*snapshot, *slot, value);
    if (!shown) return {std::string(takt::name(shown.error().code))};
    if (rounded) *rounded = shown->rounded;
    std::vector<std::string> frames;
    for (const auto& frame : shown->frames) {
        frames.push_back(wire::hex({frame.raw.data(), frame.raw.size() - 2}));  // without the checksum
        EXPECT_GT(frame.bus_time, Duration{});
        EXPECT_FALSE(frame.words.empty());
    }
    return frames;
}

using Frames = std::vector<std::string>;

TEST(CommandPreview, ShowsSingleWrites) {
    EXPECT_EQ(frames_of(host::test::variable_of("A", 5, ", write: 0x06"), "A", std::int64_t{258}),
              Frames{"01 06 00 05 01 02"});
    EXPECT_EQ(frames_of(host::test::variable_of("A", 5, ", write: 0x10"), "A", std::int64_t{1}),
              Frames{"01 10 00 05 00 01 02 00 01"});
}

TEST(CommandPreview, ShowsCoils) {
    EXPECT_EQ(frames_of("          - {name: A, type: bool, coil: 3, read: 0x01, write: 0x05}\n", "A", true),
              Frames{"01 05 00 03 FF 00"});
}

TEST(CommandPreview, ShowsBothStepsOfABit) {
    const std::string bit =
        "          - {name: A, type: bool, register: 5, bit: 3, read: 0x03, write: 0x06}\n";
    EXPECT_EQ(frames_of(bit, "A", true, ", read_modify_write: true"),
              (Frames{"01 03 00 05 00 01", "01 06 00 05 00 08"}));
    EXPECT_EQ(frames_of(bit, "A", true, ", fc22: true, high_byte_first: false"),
              Frames{"01 16 00 05 F7 FF 08 00"});
}

TEST(CommandPreview, ReportsWhatCannotBeWritten) {
    EXPECT_EQ(frames_of(host::test::variable_of("A", 5), "A", std::int64_t{1}), Frames{"not_writable"});
    EXPECT_EQ(frames_of(host::test::variable_of("A", 5, ", write: 0x06"), "A", std::int64_t{70000}),
              Frames{"overflow"});
}

TEST(CommandPreview, ReportsRounding) {
    bool rounded = false;
    frames_of(host::test::variable_of("A", 5, ", write: 0x06, scale: 0.1"), "A", 1.26, "", &rounded);
    EXPECT_TRUE(rounded);
}

}  // namespace command_preview_test
}  // namespace takt::web
