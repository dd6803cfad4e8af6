// With random faults on the line and random commands: every command has one outcome, time goes on,
// and what a slot shows as good was read.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <set>

#include "bench.hpp"

namespace takt::poll {
namespace chaos_test {

using namespace test;

model::Project project_of_all_kinds() {
    auto first = device(
        1, {int16("a", 0).read(3).write(0x10).on_change(), int16("b", 1).read(3).write(0x10).on_change(),
            int16("c", 9).read(4).every(100ms), boolean("d", 0, 1).read(1).write(0x05).repeatable()});
    auto second = device(
        2, {real("e", 0).read(3).write(0x10).write_on(1), int16("f", 8).read(3).read_on(1).every(150ms)});
    auto third = device(3, {int16("g", 0).write(0x06).on_change(), int16("h", 5).write(0x06).repeatable()});
    second.poll_enable = 0;
    first.status = 2;
    return project({first, second, third}, {local("on"), local("go"), local("status", DataType::int16)});
}

void disturb(Bench& bench, Player& player) {
    switch (*rc::gen::inRange(0, 8)) {
        case 0: player.dead = !player.dead; break;
        case 1: player.exception = *rc::gen::arbitrary<std::uint8_t>(); break;
        case 2: player.exception.reset(); break;
        case 3: player.turnaround = *rc::gen::inRange(0, 250) * 1ms; break;
        case 4: player.ignores_writes = !player.ignores_writes; break;
        case 5: bench.link(!*rc::gen::arbitrary<bool>()); break;
        case 6: {
            const auto noise =
                *rc::gen::container<std::vector<std::uint8_t>>(rc::gen::arbitrary<std::uint8_t>());
            bench.master.line(0).on_bytes(bench.now, noise);
            break;
        }
        default: player = Player{}; break;
    }
}

RC_GTEST_PROP(Chaos, EveryCommandHasExactlyOneOutcome, ()) {
    Bench bench(project_of_all_kinds());
    std::set<value::CommandId> accepted;
    const char* const kVariables[] = {"a", "b", "d", "e", "g", "h"};
    const auto steps = *rc::gen::inRange(5, 40);
    Duration end{};
    for (int i = 0; i < steps; ++i) {
        end += *rc::gen::inRange(0, 400) * 1ms;
        bench.run_until(end);
        disturb(bench, bench.players[*rc::gen::inRange<std::uint8_t>(1, 4)]);
        const auto name = kVariables[*rc::gen::inRange(0, 6)];
        const auto value = *rc::gen::inRange<std::int64_t>(0, 2);
        const auto id = static_cast<value::CommandId>(i);
        if (*rc::gen::arbitrary<bool>() && bench.write(id, name, value, *rc::gen::inRange(0, 3000) * 1ms))
            accepted.insert(id);
        if (*rc::gen::arbitrary<bool>()) RC_ASSERT(bench.set(name, value).has_value());
        for (const char* local : {"on", "go"})
            RC_ASSERT(bench.set(local, *rc::gen::arbitrary<bool>()).has_value());
    }
    bench.link(true);
    for (auto& [unit, player] : bench.players) player = Player{};
    RC_ASSERT(bench.set("on", true).has_value());
    bench.run_until(end + 75s);
    std::set<value::CommandId> ended;
    for (const auto& outcome : bench.outcomes) RC_ASSERT(ended.insert(outcome.id).second);
    RC_ASSERT(ended == accepted);
    for (const char* name : {"a", "b", "c", "d", "e", "f"})
        RC_ASSERT(bench.slot(name).quality == value::Quality::good);
    RC_ASSERT(bench.status("status") == 0);
}

}  // namespace chaos_test
}  // namespace takt::poll
