// Which settings, hosts and units a scan tries, and in which order. Nothing is sent here.
#include "takt/bus/scan_target.hpp"

#include <gtest/gtest.h>

#include <string>

#include "takt/model/target_url.hpp"

namespace takt::bus {
namespace scan_target_test {

using namespace std::chrono_literals;
using wire::Parity;
using Settings = std::vector<std::string>;

model::Line serial_line(wire::CharacterFormat format = {19200, 8, Parity::even, 1}) {
    model::Line line;
    line.name = line.port = "/dev/ttyUSB0";
    line.format = format;
    return line;
}

model::Line tcp_line(std::string host) {
    model::Line line;
    line.transport = model::Transport::tcp;
    line.framing = wire::Framing::tcp;
    line.port = std::move(host);
    return line;
}

Settings settings_of(const ScanTarget& target) {
    Settings settings;
    for (const auto& line : target.settings) settings.push_back(model::settings_text(line));
    return settings;
}

TEST(ScanTarget, TriesTheUsualSettingsTheLikelyOnesFirst) {
    const auto settings = settings_of(serial_target(serial_line(), "rtu:///dev/ttyUSB0", {}));
    ASSERT_EQ(settings.size(), 15U);
    EXPECT_EQ(settings[0], "19200 8E1") << "the default of the specification";
    EXPECT_EQ(settings[1], "9600 8N1");
    EXPECT_EQ(settings.back().substr(settings.back().size() - 3), "8O1");
}

TEST(ScanTarget, AListHoldsBeforeTheUrlAndTheUrlBeforeTheUsual) {
    const auto line = serial_line({4800, 8, Parity::odd, 2});
    const struct {
        const char* url;
        SerialChoices choices;
        Settings settings;
    } cases[] = {
        {"rtu:///dev/ttyUSB0?baud=4800&parity=odd&stop_bits=2", {}, {"4800 8O2"}},
        {"rtu:///dev/ttyUSB0?baud=4800&parity=odd", {}, {"4800 8O1"}},
        {"rtu:///dev/ttyUSB0?baud=4800&parity=odd", {.bauds = {1200}}, {"1200 8O1"}},
        {"rtu:///dev/ttyUSB0?parity=odd",
         {.bauds = {1200, 9600}, .stop_bits = {1, 2}},
         {"9600 8O1", "9600 8O2", "1200 8O1", "1200 8O2"}},
        {"rtu:///dev/ttyUSB0?baud=4800", {.parities = {Parity::odd, Parity::none}}, {"4800 8N1", "4800 8O1"}},
        {"rtu:///dev/ttyUSB0", {{7777}, {Parity::none}, {1}}, {"7777 8N1"}},
    };
    for (const auto& [url, choices, settings] : cases) {
        auto tried = settings_of(serial_target(line, url, choices));
        if (settings.size() > 2) {
            EXPECT_EQ(tried.front(), settings.front()) << url;
            EXPECT_EQ(tried.size(), settings.size()) << url;
        } else {
            EXPECT_EQ(tried, settings) << url;
        }
    }
}

TEST(ScanTarget, SevenBitsWithoutParityHaveTwoStopBits) {
    auto line = serial_line({9600, 7, Parity::none, 1});
    line.framing = wire::Framing::ascii;
    const auto settings =
        settings_of(serial_target(line, "ascii:///dev/ttyUSB0?baud=9600&parity=none", {.stop_bits = {1, 2}}));
    EXPECT_EQ(settings, (Settings{"9600 7N2", "9600 7N1"}));
}

TEST(ScanTarget, TheHostsOfARange) {
    const auto range = parse_host_range("10.0.0.254-10.0.1.1").value().value();
    const auto targets = host_targets(tcp_line("10.0.0.254"), range);
    ASSERT_EQ(targets.size(), 4U);
    EXPECT_EQ(model::url_of(targets[0].settings[0]), "tcp://10.0.0.254:502");
    EXPECT_EQ(model::url_of(targets[3].settings[0]), "tcp://10.0.1.1:502");
    EXPECT_EQ(targets[3].settings[0].name, "10.0.1.1:502");
    EXPECT_TRUE(targets[0].of_range);
    EXPECT_FALSE(host_targets(tcp_line("10.0.0.9"), {9, 9})[0].of_range) << "one host";
}

TEST(ScanTarget, TheSameTargetIsAddedOnce) {
    std::vector<ScanTarget> targets;
    ASSERT_TRUE(add_targets(targets, {{{tcp_line("a")}, false}, {{tcp_line("b")}, false}}, "x"));
    ASSERT_TRUE(add_targets(targets, {{{tcp_line("b")}, true}, {{tcp_line("c")}, false}}, "x"));
    EXPECT_EQ(targets.size(), 3U);
    const auto port = serial_target(serial_line(), "", {});
    const auto other = serial_target(serial_line(), "", {.bauds = {9600}});
    ASSERT_TRUE(add_targets(targets, {port, port, other}, "x"));
    EXPECT_EQ(targets.size(), 5U) << "other settings are another target";
}

TEST(ScanTarget, TooManyTargetsAreRefused) {
    std::vector<ScanTarget> targets;
    ASSERT_TRUE(add_targets(targets, host_targets(tcp_line(""), {1, kMaxScanTargets}), "range"));
    const auto beyond = add_targets(targets, {{{tcp_line("one-more")}, false}}, "tcp://one-more");
    EXPECT_EQ(beyond.error(),
              fail(Code::out_of_range, "tcp://one-more", kMaxScanTargets + 1, 1, kMaxScanTargets).error());
}

TEST(ScanTarget, WaitsAndUnitsByTheKindOfTheLine) {
    const ScanRequest request{.units = {0, 1, 247, 248, 255}};
    const auto serial = scan_config(request, serial_target(serial_line(), "", {})).value();
    EXPECT_EQ(serial.units, (std::vector{UnitId{1}, UnitId{247}})) << "the addresses of a serial line";
    EXPECT_EQ(serial.wait, 100ms);
    EXPECT_EQ(serial.retry_wait, 500ms) << "at least";
    const auto network = scan_config(request, {{tcp_line("host")}, false}).value();
    EXPECT_EQ(network.units.size(), 5U);
    EXPECT_EQ(network.wait, 1s);
    EXPECT_EQ(network.retry_wait, 4s);
}

TEST(ScanTarget, AllUnitsThoseOfTheHostFirst) {
    const auto serial = scan_config({}, serial_target(serial_line(), "", {})).value();
    ASSERT_EQ(serial.units.size(), 247U);
    EXPECT_EQ(serial.units.front(), UnitId{1});
    EXPECT_FALSE(serial.adaptive);
    const auto network = scan_config({}, {{tcp_line("host")}, false}).value();
    ASSERT_EQ(network.units.size(), 249U);
    EXPECT_EQ(std::vector(network.units.begin(), network.units.begin() + 4),
              (std::vector{UnitId{1}, UnitId{0}, UnitId{255}, UnitId{2}}));
    EXPECT_EQ(network.units.back(), UnitId{247});
    EXPECT_TRUE(network.adaptive);
    EXPECT_FALSE(scan_config({.wait = 250ms}, {{tcp_line("host")}, false}).value().adaptive)
        << "a time-out that the user gives is the time-out";
}

TEST(ScanTarget, TheRequestGoesIntoTheConfiguration) {
    const ScanRequest request{.units = {7}, .wait = 250ms, .identify = false, .thorough = true};
    const auto config = scan_config(request, serial_target(serial_line(), "", {})).value();
    EXPECT_EQ(config.wait, 250ms);
    EXPECT_EQ(config.retry_wait, 1s);
    EXPECT_FALSE(config.identify);
    EXPECT_TRUE(config.thorough);
    const auto none = scan_config({.units = {0, 255}}, serial_target(serial_line(), "", {}));
    EXPECT_EQ(none.error(), fail(Code::out_of_range, 0, 1, 247).error());
}

}  // namespace scan_target_test
}  // namespace takt::bus
