// Bits of registers: by 0x16, by read-modify-write, and the function a value is written with by command.
#include <gtest/gtest.h>

#include <algorithm>

#include "bench.hpp"

namespace takt::poll {
namespace bits_test {

using namespace test;
using value::CommandResult;
using value::Reason;

/// PDUs of what was sent since the last call and is no polling: reads of one register are no polling here.
std::vector<std::string> pdus(Bench& bench) {
    std::vector<std::string> sent;
    for (const auto& request : bench.news())
        sent.push_back(request.bytes.substr(3, request.bytes.size() - 9));
    return sent;
}
using Pdus = std::vector<std::string>;

Item bit(std::string name, int number, int at) {
    return boolean(std::move(name), number, at).write(0x06);
}

model::Device with_mask(model::Device device) {
    device.fc22 = true;
    return device;
}
model::Device with_modify(model::Device device) {
    device.read_modify_write = true;
    return device;
}

/// One request that writes all variables of the device's register 0 as the device can.
plan::Plan bits_plan(const model::Project& project) {
    const auto& device = project.lines[0].devices[0];
    plan::Plan plan;
    auto& line = plan.lines.emplace_back();
    auto& request = line.requests.emplace_back();
    for (std::size_t i = 0; i < device.variables.size(); ++i) request.variables.push_back(i);
    request.write = device.fc22 ? Function::mask_write_register : Function::write_single_register;
    request.read_modify_write = !device.fc22;
    request.quantity = 1;
    request.write_on_change = device.variables[0].write_on_change;
    request.write_trigger = device.variables[0].write_trigger;
    return plan;
}

Bench bench_of(const model::Device& device) {
    auto described = project({device}, {local("go")});
    const auto plan = bits_plan(described);
    return {std::move(described), plan};
}

TEST(Bits, AMaskNamesTheBitsThatWereSetAndNoOthers) {
    auto bench = bench_of(with_mask(device(1, {bit("a", 0, 3).on_change(), bit("b", 0, 9).on_change()})));
    bench.players[1].registers[0] = 0xF0F0;
    ASSERT_TRUE(bench.set("a", true));
    bench.run_until(20ms);
    EXPECT_EQ(pdus(bench), Pdus{"16 00 00 FF F7 00 08"});
    EXPECT_EQ(bench.players[1].registers[0], 0xF0F8);
    // Another master takes it back; a change of the other bit leaves it so.
    bench.players[1].registers[0] = 0;
    ASSERT_TRUE(bench.set("b", true));
    bench.run_until(40ms);
    EXPECT_EQ(pdus(bench), Pdus{"16 00 00 FD FF 02 00"});
    EXPECT_EQ(bench.players[1].registers[0], 0x0200);
    ASSERT_TRUE(bench.set("a", true));
    ASSERT_TRUE(bench.set("b", false));
    bench.run_until(60ms);
    EXPECT_EQ(pdus(bench), Pdus{"16 00 00 FD F7 00 08"});
    EXPECT_EQ(bench.players[1].registers[0], 0x0008);
}

TEST(Bits, ATriggerWritesAllThatWasSet) {
    auto bench = bench_of(with_mask(
        device(1, {bit("a", 0, 0).write_on(0), bit("b", 0, 1).write_on(0), bit("c", 0, 2).write_on(0)})));
    ASSERT_TRUE(bench.set("go", true));
    bench.run_until(20ms);
    EXPECT_TRUE(pdus(bench).empty());
    EXPECT_EQ(bench.observed.waiting, std::vector<std::size_t>{0});
    ASSERT_TRUE(bench.set("a", true));
    ASSERT_TRUE(bench.set("c", false));
    bench.run_until(40ms);
    EXPECT_EQ(pdus(bench), Pdus{"16 00 00 FF FA 00 01"});
}

TEST(Bits, ReadModifyWriteKeepsTheOthersAndNothingComesBetween) {
    auto described = with_modify(device(1, {bit("a", 0, 3).on_change()}));
    auto other = device(2, {int16("other", 0).write(0x06)});
    auto planned = project({described, other});
    const auto plan = bits_plan(planned);
    Bench bench(planned, plan);
    bench.players[1].registers[0] = 0x1234;
    ASSERT_TRUE(bench.set("a", true));
    bench.run_until(1900us);  // the read is on its way
    ASSERT_EQ(pdus(bench), Pdus{"03 00 00 00 01"});
    ASSERT_TRUE(bench.write(1, "other", std::int64_t{7}));
    bench.run_until(40ms);
    EXPECT_EQ(pdus(bench), (Pdus{"06 00 00 12 3C", "06 00 00 00 07"}));
    EXPECT_EQ(bench.players[1].registers[0], 0x123C);
    EXPECT_EQ(bench.slot("a").value, value::Value(true));
}

TEST(Bits, ACommandWhoseBitIsSetAnewBetweenReadAndWriteIsSuperseded) {
    auto bench = bench_of(with_modify(device(1, {bit("a", 0, 3).on_change()})));
    ASSERT_TRUE(bench.write(1, "a", false));
    bench.run_until(1900us);  // the read is on its way
    ASSERT_EQ(pdus(bench), Pdus{"03 00 00 00 01"});
    ASSERT_TRUE(bench.set("a", true));
    bench.run_until(40ms);
    EXPECT_EQ(bench.players[1].registers[0], 1U << 3U);
    const auto& outcomes = bench.outcomes;
    ASSERT_EQ(outcomes.size(), 1U);
    EXPECT_EQ(outcomes[0].result, CommandResult::refused);
    EXPECT_EQ(outcomes[0].reason, Reason::superseded);
}

struct Failure {
    const char* what;
    std::function<void(Player&)> during_read;
    std::function<void(Player&)> during_write;
    CommandResult result;
    Reason reason;
    std::size_t transmissions;
};

const Failure kFailures[] = {
    {"done", {}, {}, CommandResult::done, Reason::ok, 2},
    {"the read is refused",
     [](Player& p) { p.exception = 2; },
     {},
     CommandResult::refused,
     value::exception_reason(2),
     1},
    {"no answer to the read: nothing was written, so it is tried again",
     [](Player& p) { p.dead = true; },
     {},
     CommandResult::refused,
     Reason::timeout,
     3},
    {"the write is refused",
     {},
     [](Player& p) { p.exception = 3; },
     CommandResult::refused,
     value::exception_reason(3),
     2},
    {"no answer to the write",
     {},
     [](Player& p) { p.dead = true; },
     CommandResult::unknown,
     Reason::timeout,
     2},
    {"busy", {}, [](Player& p) { p.exception = 6; }, CommandResult::refused, value::exception_reason(6), 4},
};

// Twice: by the group of the bit, and by a command alone.
TEST(Bits, EachFailureOfAReadModifyWriteHasItsOutcome) {
    for (const auto& c : kFailures)
        for (const bool grouped : {true, false}) {
            const auto item = bit("a", 0, 3);
            const auto described = project(
                {with_modify(device(1, {grouped ? item.on_change() : item.write_on(0)}))}, {local("go")});
            Bench bench(described, bits_plan(described));
            auto& player = bench.players[1];
            if (c.during_read) c.during_read(player);
            ASSERT_TRUE(bench.write(9, "a", true, 60s));
            bench.run_until(2ms);  // the read was answered or not
            if (c.during_write) c.during_write(player);
            bench.run_until(20s);
            ASSERT_EQ(bench.outcomes.size(), 1U) << c.what;
            EXPECT_EQ(bench.outcomes[0].result, c.result) << c.what;
            EXPECT_EQ(bench.outcomes[0].reason, c.reason) << c.what;
            EXPECT_EQ(bench.sent.size(), c.transmissions) << c.what << grouped;
        }
}

TEST(Bits, ALinkLostBetweenReadAndWriteStartsAnew) {
    for (const bool grouped : {true, false}) {
        const auto item = bit("a", 0, 3);
        const auto described =
            project({with_modify(device(1, {grouped ? item.on_change() : item.write_on(0)}))}, {local("go")});
        Bench bench(described, bits_plan(described));
        bench.players[1].turnaround = 1ms;
        ASSERT_TRUE(bench.write(1, "a", true));
        bench.run_until(5ms);  // read, and the silence before the write
        ASSERT_EQ(pdus(bench), Pdus{"03 00 00 00 01"});
        bench.link(false);
        bench.run_until(100ms);
        bench.players[1].registers[0] = 0x0100;
        bench.link(true);
        bench.run_until(200ms);
        EXPECT_EQ(pdus(bench), (Pdus{"03 00 00 00 01", "06 00 00 01 08"}));
        ASSERT_EQ(bench.outcomes.size(), 1U);
        EXPECT_EQ(bench.outcomes[0].result, CommandResult::done);
    }
}

TEST(Bits, ADeviceSwitchedOffBetweenReadAndWriteIsLeftAlone) {
    auto described = with_modify(device(1, {bit("a", 0, 3).on_change()}));
    described.poll_enable = 0;
    auto on = local("on");
    on.default_value = model::Constant{.integer = 1};
    auto planned = project({described}, {on});
    Bench bench(planned, bits_plan(planned));
    bench.players[1].turnaround = 1ms;
    ASSERT_TRUE(bench.write(1, "a", true));
    bench.run_until(5ms);
    ASSERT_EQ(pdus(bench), Pdus{"03 00 00 00 01"});
    ASSERT_TRUE(bench.set("on", false));
    bench.run_until(1s);
    EXPECT_TRUE(pdus(bench).empty());
    ASSERT_EQ(bench.outcomes.size(), 1U);
    EXPECT_EQ(bench.outcomes[0].result, CommandResult::refused);
    EXPECT_EQ(bench.outcomes[0].reason, Reason::switched_off);
}

struct Command {
    const char* what;
    Item item;
    model::WriteSingle mode;
    bool fc22, modify;
    Pdus expected;
};

const Command kCommands[] = {
    {"as declared",
     int16("v", 4).write(0x10),
     model::WriteSingle::as_declared,
     false,
     false,
     {"10 00 04 00 01 02 00 01"}},
    {"the cheaper one",
     int16("v", 4).write(0x10),
     model::WriteSingle::allowed,
     false,
     false,
     {"06 00 04 00 01"}},
    {"only", int16("v", 4).write(0x10), model::WriteSingle::only, false, false, {"06 00 04 00 01"}},
    {"never",
     int16("v", 4).write(0x06),
     model::WriteSingle::never,
     false,
     false,
     {"10 00 04 00 01 02 00 01"}},
    {"never, a coil",
     boolean("v", 0, 4).write(0x05),
     model::WriteSingle::never,
     false,
     false,
     {"0F 00 04 00 01 01 01"}},
    {"only, a coil",
     boolean("v", 0, 4).write(0x0F),
     model::WriteSingle::only,
     false,
     false,
     {"05 00 04 FF 00"}},
    {"a bit by mask", bit("v", 4, 0), model::WriteSingle::as_declared, true, true, {"16 00 04 FF FE 00 01"}},
    {"a bit by read-modify-write",
     bit("v", 4, 0),
     model::WriteSingle::as_declared,
     false,
     true,
     {"03 00 04 00 01", "06 00 04 00 81"}},
    {"a bit, never by 0x06",
     bit("v", 4, 0),
     model::WriteSingle::never,
     false,
     true,
     {"03 00 04 00 01", "10 00 04 00 01 02 00 81"}},
};

TEST(Bits, CommandsUseTheFunctionsTheDeviceTakes) {
    for (const auto& c : kCommands) {
        auto described = device(1, {c.item});
        described.write_single = c.mode;
        described.fc22 = c.fc22;
        described.read_modify_write = c.modify;
        Bench bench(project({described}));
        bench.players[1].registers[4] = 0x80;
        const bool is_bool = c.item.type == DataType::boolean;
        ASSERT_TRUE(bench.write(1, "v", is_bool ? value::Value(true) : value::Value(std::int64_t{1})))
            << c.what;
        bench.run_until(50ms);
        EXPECT_EQ(pdus(bench), c.expected) << c.what;
        ASSERT_EQ(bench.outcomes.size(), 1U) << c.what;
        EXPECT_EQ(bench.outcomes[0].result, CommandResult::done) << c.what;
    }
}

// The bit is counted after the byte order was applied, as a read has it.
TEST(Bits, OfARegisterWithTheLowByteFirst) {
    for (const bool mask : {true, false}) {
        auto described = device(1, {bit("v", 4, 3).on_change()});
        described.variables[0].order.high_byte_first = false;
        described.fc22 = mask;
        described.read_modify_write = !mask;
        Bench bench(project({described}));
        bench.players[1].registers[4] = 0x8001;
        ASSERT_TRUE(bench.write(1, "v", true));
        bench.run_until(50ms);
        EXPECT_EQ(bench.players[1].registers[4], 0x8801) << mask;
    }
}

TEST(Bits, WhereTheDeviceHasNoWayACommandIsRefusedAtOnce) {
    Bench bench(project({device(1, {bit("v", 4, 0)})}));
    EXPECT_EQ(bench.write(1, "v", true).error().code, Code::unsupported);
    bench.run_until(50ms);
    EXPECT_TRUE(bench.sent.empty());
}

TEST(Bits, ExpiredCommandsLeaveNoBitBehind) {
    for (const std::uint64_t commands : {1U, 2U}) {
        auto bench = bench_of(with_mask(device(1, {bit("a", 0, 3).on_change(), bit("b", 0, 9).on_change()})));
        bench.link(false);
        for (std::uint64_t id = 1; id <= commands; ++id)
            ASSERT_TRUE(bench.write(id, "a", true, (8 + 2 * id) * 1ms));
        bench.run_until(20ms);
        ASSERT_EQ(bench.outcomes.size(), commands);
        bench.link(true);
        ASSERT_TRUE(bench.set("b", true));
        bench.run_until(60ms);
        EXPECT_EQ(pdus(bench), Pdus{"16 00 00 FD FF 02 00"}) << commands;
    }
}

TEST(Bits, AnExpiredCommandTakesNoBitFromOneThatIsRepeated) {
    auto bench = bench_of(with_modify(device(1, {bit("a", 0, 3).on_change()})));
    bench.players[1].dead = true;
    ASSERT_TRUE(bench.write(1, "a", true, 60s));
    bench.run_until(1900us);  // its read is on its way, and will not be answered
    ASSERT_TRUE(bench.write(2, "a", true, 2ms));
    bench.run_until(5ms);
    ASSERT_EQ(bench.outcomes.size(), 1U);
    bench.players[1].dead = false;
    bench.run_until(10s);
    ASSERT_EQ(bench.outcomes.size(), 2U);
    EXPECT_EQ(bench.outcomes[1].result, CommandResult::done);
    EXPECT_EQ(bench.players[1].registers[0], 1U << 3U);
}

// Commands that are dropped with their device must not replace the command whose outcome is checked.
TEST(Bits, ADeviceThatDiesUnderAReadModifyWriteDelaysNoOther) {
    auto dying = with_modify(device(1, {bit("a", 0, 3), bit("b", 1, 4), int16("v", 9).read(3)}));
    dying.attempts = 2;
    const auto described = project({dying, device(2, {int16("w", 0).read(3)})});
    Bench bench(described, plan::make_plan(described));
    bench.run_until(50ms);
    bench.players[1].exception = 6;  // the first command will wait until its time is over
    ASSERT_TRUE(bench.write(1, "a", true));
    bench.run_until(60ms);
    bench.players[1].exception.reset();
    bench.players[1].dead = true;
    ASSERT_TRUE(bench.write(2, "b", true));
    ASSERT_TRUE(bench.write(3, "a", false));
    bench.run_until(5s);
    ASSERT_EQ(bench.outcomes.size(), 3U);
    for (const auto& outcome : bench.outcomes)
        EXPECT_EQ(outcome.result, CommandResult::refused) << outcome.id;
    bench.players[1].dead = false;
    bench.news();
    bench.run_until(10s);
    EXPECT_GT(bench.news().size(), 50U);  // both devices are polled again
    EXPECT_EQ(bench.slot("w").quality, value::Quality::good);
}

}  // namespace bits_test
}  // namespace takt::poll
