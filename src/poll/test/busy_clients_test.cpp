// Clients that never pause: their commands, triggers and set values leave the line to polling.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "bench.hpp"

namespace takt::poll {
namespace busy_clients_test {

using namespace test;
using value::CommandResult;
using value::Value;

Value number(std::int64_t value) {
    return value;
}

/// Two clients, each of which writes its next value when the last one has its outcome.
void two_writers(Bench& bench, const std::array<const char*, 2>& variables) {
    bench.after_each = [&bench, variables, sent = std::uint64_t{0}]() mutable {
        for (; sent < bench.outcomes.size() + 2; ++sent)
            ASSERT_TRUE(bench.write(sent, variables.at(sent % 2),
                                    number(static_cast<std::int64_t>(sent % 30'000)), 10s));
    };
    bench.after_each();
}

std::int64_t polls(const Bench& bench, int unit) {
    return std::ranges::count_if(bench.sent,
                                 [unit](const Sent& s) { return s.unit == unit && s.function == 3; });
}

std::ptrdiff_t results(const Bench& bench, CommandResult result) {
    return std::ranges::count(bench.outcomes, result, &value::CommandOutcome::result);
}

TEST(ClientsThatNeverPause, LeaveTheLineToPolling) {
    for (const bool in_groups : {false, true}) {
        auto a = int16("a", 1).read(3).write(0x06).every(100ms);
        auto b = int16("b", 50).read(3).write(0x06).every(100ms);
        auto described = project({device(1, {in_groups ? a.on_change() : a, in_groups ? b.on_change() : b})});
        Bench bench(described);
        two_writers(bench, {"a", "b"});
        bench.run_until(10s);
        EXPECT_GE(polls(bench, 1), 198) << "of 100 each";
        EXPECT_GT(results(bench, CommandResult::done), 500) << "what polling leaves is for them";
        EXPECT_EQ(results(bench, CommandResult::expired), 0);
    }
}

TEST(ClientsThatNeverPause, HaveTheirShareOfALineThatPollingFills) {
    std::vector<model::Device> devices;
    for (int d = 1; d <= 6; ++d)
        devices.push_back(device(d, {int16("r" + std::to_string(d), 0).read(3).every(10ms),
                                     int16("w" + std::to_string(d), 9).write(0x06)}));
    auto described = project(devices);
    described.lines[0].commands = {.min_interval = 100ms, .burst = 1};
    Bench bench(described);
    ASSERT_GT(bench.plan.lines[0].utilization, 1);
    two_writers(bench, {"w1", "w2"});
    bench.run_until(10s);
    const auto done = results(bench, CommandResult::done);
    EXPECT_GE(done, 80);
    EXPECT_LE(done, 101) << "one each interval, counted from its end";
    for (int d = 1; d <= 6; ++d) EXPECT_GT(polls(bench, d), 50) << "device " << d;
    std::vector<value::CommandId> order;
    for (const auto& outcome : bench.outcomes) order.push_back(outcome.id);
    EXPECT_TRUE(std::ranges::is_sorted(order)) << "first come, first served";
}

// A trigger that rises again, and a value that is set again, as soon as the last one was served: by a client
// that writes a local, or by a rule that follows a polled value.
TEST(ClientsThatNeverPause, TriggersAndSetValuesLeaveTheLineToPolling) {
    for (const bool triggers : {false, true}) {
        auto described =
            project({device(1, {int16("a", 1).read(3).every(100ms), int16("b", 50).read(3).every(100ms),
                                int16("t", 200).read(4).read_on(0).every(10s),
                                int16("w", 300).write(0x06).on_change()})},
                    {local("go")});
        described.lines[0].devices[0].turnaround = 20ms;
        Bench bench(described);
        bench.players[1].turnaround = 20ms;
        const auto events = [&bench, triggers] {
            return std::ranges::count_if(bench.sent, [triggers](const Sent& sent) {
                return triggers ? sent.function == 4 : sent.function == 6;
            });
        };
        bench.after_each = [&, seen = std::ptrdiff_t{-1}, next = 0]() mutable {
            if (events() == seen) return;
            seen = events();
            if (triggers) {
                ASSERT_TRUE(bench.set("go", false));
                ASSERT_TRUE(bench.set("go", true));
            } else {
                ASSERT_TRUE(bench.set("w", number(++next % 30'000)));
            }
        };
        bench.after_each();
        bench.run_until(10s);
        EXPECT_GE(polls(bench, 1), 190) << "of 100 each, triggers: " << triggers;
        EXPECT_GT(events(), 100) << "what polling leaves is for them";
    }
}

TEST(ClientsThatNeverPause, AVerificationAndARetryBelongToTheirCommand) {
    auto described = project({device(
        1, {int16("r", 0).read(3).every(10ms), int16("w", 9).read(3).write(0x06).every(0ms).verified()})});
    described.lines[0].devices[0].attempts = 3;
    Bench bench(described);
    bench.run_until(1s);
    bench.news();
    int silent = 0;
    bench.players[1].silent_to = [&silent](const wire::Request& request) {
        return wire::function_of(request) == Function::write_single_register && silent++ < 1;
    };
    ASSERT_TRUE(bench.write(1, "w", number(4)));
    bench.run_until(1500ms);
    ASSERT_EQ(bench.outcomes.size(), 1U);
    EXPECT_EQ(bench.outcomes[0].result, CommandResult::unknown) << "a write is sent again only if it is safe";
    ASSERT_TRUE(bench.write(2, "w", number(5)));
    bench.run_until(1600ms);
    ASSERT_EQ(bench.outcomes.size(), 2U);
    EXPECT_EQ(bench.outcomes[1].result, CommandResult::done);
}

}  // namespace busy_clients_test
}  // namespace takt::poll
