// The judge reports nothing for a good history, and names the invariant that a bad one breaks.
#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "judge/limits.hpp"
#include "story.hpp"

namespace takt::simtest {
namespace judge_test {

using poll::Purpose;
using value::CommandResult;

struct Case {
    const char* what;
    const char* invariant;  ///< "": it is good
    std::function<void(Story&)> play;
};

/// Both registers are read once each, as the plan has them: one request.
void read_pair(Story& story, Duration when, std::uint16_t v, std::uint16_t w) {
    story.ask(when, 1, {3, 0, 0, 0, 2});
    story.serve(wire::Area::holding_register, 0, {v, w});
    const auto byte = [](unsigned word) { return static_cast<std::uint8_t>(word); };
    story.answer({3, 4, byte(v >> 8U), byte(v), byte(w >> 8U), byte(w)});
    story.show("v", v);
    story.show("w", w);
}

void write_pair(Story& story, Duration when, std::uint8_t v, std::uint8_t w) {
    story.ask(when, 1, {16, 0, 0, 0, 2, 4, 0, v, 0, w});
}

void write_s(Story& story, Duration when, std::uint8_t value) {
    story.ask(when, 1, {6, 0, 20, 0, value}, Purpose::write, 1);
}

/// `p` (register 30) or `q` (31) is written, and `read` comes as the answer to its verification.
void write_verified(Story& story, Duration when, value::CommandId id, std::uint8_t start, std::uint8_t value,
                    std::uint8_t read) {
    story.command(when, id, start == 30 ? "p" : "q", value);
    story.ask(when + 1ms, 1, {6, 0, start, 0, value}, Purpose::write, id);
    story.execute(start, {value});
    story.answer({6, 0, start, 0, value});
    story.ask(when + 50ms, 1, {3, 0, start, 0, 1}, Purpose::read_back, id);
    story.serve(wire::Area::holding_register, start, {value});
    story.answer({3, 2, 0, read});
    story.show(start == 30 ? "p" : "q", read);
    if (value == read)
        story.outcome(when + 80ms, id, CommandResult::done);
    else
        story.outcome(when + 80ms, id, CommandResult::refused, value::Reason::differs);
}

/// The write of `z` is confirmed. Its device was switched off meanwhile, and is on again.
void write_switched(Story& story) {
    story.command(0ms, 1, "z", 7);
    story.ask(1ms, 2, {6, 0, 50, 0, 7}, Purpose::write, 1);
    story.execute(50, {7});
    story.enable(8ms, false);
    story.enable(9ms, true);
    story.answer({6, 0, 50, 0, 7});
}

/// Register 40 of device 3 is read, `written` is confirmed but not executed, and another value is read back.
void modify_ignored(Story& story, Duration when, std::uint8_t written) {
    story.ask(when, 3, {3, 0, 40, 0, 1}, Purpose::before_write);
    story.serve(wire::Area::holding_register, 40, {0});
    story.answer({3, 2, 0, 0});
    story.ask(when + 50ms, 3, {6, 0, 40, 0, written});
    story.ignore();
    story.answer({6, 0, 40, 0, written});
    story.ask(when + 100ms, 3, {3, 0, 40, 0, 1}, Purpose::read_back);
    story.serve(wire::Area::holding_register, 40, {0});
    story.answer({3, 2, 0, 0});
}

/// The reads of `v` and `w` fail until device 1 does not answer. The values of the others stay as they are.
void lose_device(Story& story, Duration when) {
    story.ask(when, 1, {3, 0, 0, 0, 2});
    story.ask(when + 100ms, 1, {3, 0, 0, 0, 2}, Purpose::repetition);
    for (const auto* name : {"v", "w"}) story.show(name, 1, value::Quality::bad);
    story.read(when + 300ms, 2, 4, 0, "y", 400);
    story.look(when + 1200ms);
}

/// The registers of `v` and `w` are read. Register 0 of device 2 is read 100 ms later. Then `v` is shown.
void hold_pair(Story& story, Duration when, Duration held) {
    story.ask(when, 1, {3, 0, 0, 0, 2}, Purpose::repetition);
    story.serve(wire::Area::holding_register, 0, {100, 200});
    story.answer({3, 4, 0, 100, 0, 200});
    const Duration read = story.now();
    story.read(when + 100ms, 2, 4, 0, "y", 400);
    story.show_held(read + held, read, "v", 100);
}

const Case kCases[] = {
    {"a value that was held back, after a failure", "",
     [](Story& story) {
         story.ask(0ms, 1, {3, 0, 0, 0, 2});
         hold_pair(story, 200ms, 500ms);
     }},
    {"a value that was held back for too long", "value_own",
     [](Story& story) {
         story.ask(0ms, 1, {3, 0, 0, 0, 2});
         hold_pair(story, 200ms, 1001ms);
     }},
    {"a value that was held back, and another one was read", "value_own",
     [](Story& story) {
         story.ask(0ms, 1, {3, 0, 0, 0, 2});
         story.ask(200ms, 1, {3, 0, 0, 0, 2}, Purpose::repetition);
         story.serve(wire::Area::holding_register, 0, {101, 200});
         story.answer({3, 4, 0, 101, 0, 200});
         const Duration read = story.now();
         story.read(300ms, 2, 4, 0, "y", 400);
         story.show_held(read + 500ms, read, "v", 100);
     }},
    {"polling does not go on", "polling_advances",
     [](Story& story) {
         story.look(300ms);
         story.look(60s);
     }},
    {"bad, and nothing happened to its device", "quality_own",
     [](Story& story) {
         read_pair(story, 0ms, 100, 200);
         story.show("v", 1, value::Quality::bad);
     }},
    {"bad, its device was switched off", "",
     [](Story& story) {
         story.read(0ms, 2, 4, 0, "y", 400);
         story.enable(100ms, false);
         story.show("y", 400, value::Quality::bad);
     }},
    {"a good history", "",
     [](Story& story) {
         read_pair(story, 0ms, 100, 200);
         story.read(100ms, 1, 4, 10, "x", 300);
         story.read(200ms, 2, 4, 0, "y", 400);
         story.set(300ms, "v", 7);
         write_pair(story, 301ms, 7, 200);
         story.execute(0, {7, 200});
         story.answer({16, 0, 0, 0, 2});
         story.command(400ms, 1, "s", 9);
         write_s(story, 401ms, 9);
         story.execute(20, {9});
         story.answer({6, 0, 20, 0, 9});
         story.outcome(430ms, 1, CommandResult::done);
         read_pair(story, 1000ms, 7, 200);
         read_pair(story, 2000ms, 7, 201);
         story.read(2100ms, 1, 4, 10, "x", 301);
         story.look(2500ms);
         story.finish(2600ms);
     }},
    {"a value that the device did not give", "value_own",
     [](Story& story) {
         read_pair(story, 0ms, 100, 200);
         story.show("v", 200);
     }},
    {"the answer to another request", "value_own",
     [](Story& story) {
         read_pair(story, 0ms, 100, 200);
         story.ask(100ms, 1, {4, 0, 10, 0, 1});
         story.show("v", 101);
     }},
    {"a value that stays good", "value_true",
     [](Story& story) {
         read_pair(story, 0ms, 100, 200);
         story.look(5s);
     }},
    {"a good value of a device that does not answer", "value_true",
     [](Story& story) {
         read_pair(story, 0ms, 100, 200);
         story.read(100ms, 1, 4, 10, "x", 300);
         lose_device(story, 1000ms);
     }},
    {"a written value compared by a copy, then its device does not answer", "",
     [](Story& story) {
         read_pair(story, 0ms, 100, 200);
         write_verified(story, 200ms, 1, 31, 5, 5);
         write_verified(story, 400ms, 2, 30, 6, 5);
         lose_device(story, 1000ms);
     }},
    {"a write without an order", "write_done_exact", [](Story& story) { write_s(story, 0ms, 9); }},
    {"another value than ordered", "write_done_exact",
     [](Story& story) {
         story.command(0ms, 1, "s", 9);
         write_s(story, 1ms, 8);
     }},
    {"done without having been done", "write_done_exact",
     [](Story& story) {
         story.command(0ms, 1, "s", 9);
         write_s(story, 1ms, 9);
         story.answer({6, 0, 20, 0, 9});
         story.outcome(30ms, 1, CommandResult::done);
     }},
    {"one write executed late, the next one ignored", "",
     [](Story& story) {
         story.command(0ms, 1, "s", 8);
         write_s(story, 1ms, 8);
         story.outcome(100ms, 1, CommandResult::unknown);
         story.command(200ms, 2, "s", 9);
         story.ask(201ms, 1, {6, 0, 20, 0, 9}, Purpose::write, 2);
         story.execute(20, {8});
         story.ignore();
         story.answer({6, 0, 20, 0, 9});
         story.outcome(230ms, 2, CommandResult::done);
     }},
    {"read back behind overdue polling, its device was off meanwhile", "",
     [](Story& story) {
         write_switched(story);
         story.read(50ms, 2, 4, 0, "y", 400);
         story.ask(100ms, 2, {3, 0, 50, 0, 1}, Purpose::read_back, 1);
     }},
    {"read back after another write of its device, which was off meanwhile", "request_was_due",
     [](Story& story) {
         write_switched(story);
         story.command(40ms, 2, "z", 8);
         story.ask(50ms, 2, {6, 0, 50, 0, 8}, Purpose::write, 2);
         story.ask(200ms, 2, {3, 0, 50, 0, 1}, Purpose::read_back, 1);
     }},
    {"refused and done", "write_done_exact",
     [](Story& story) {
         story.command(0ms, 1, "s", 9);
         write_s(story, 1ms, 9);
         story.execute(20, {9});
         story.answer({6, 0, 20, 0, 9});
         story.outcome(30ms, 1, CommandResult::refused);
     }},
    {"done twice by one request", "write_unknown_bounded",
     [](Story& story) {
         story.command(0ms, 1, "s", 9);
         write_s(story, 1ms, 9);
         story.execute(20, {9});
         story.execute(20, {9});
     }},
    {"unknown and never sent", "write_unknown_bounded",
     [](Story& story) {
         story.command(0ms, 1, "s", 9);
         story.outcome(30ms, 1, CommandResult::unknown);
     }},
    {"sent again although nothing is known of it", "unsafe_not_repeated",
     [](Story& story) {
         story.command(0ms, 1, "s", 9);
         write_s(story, 1ms, 9);
         write_s(story, 200ms, 9);
     }},
    {"two outcomes", "outcome_once",
     [](Story& story) {
         story.command(0ms, 1, "s", 9);
         story.outcome(10ms, 1, CommandResult::expired);
         story.outcome(11ms, 1, CommandResult::expired);
     }},
    {"no outcome", "outcome_once",
     [](Story& story) {
         read_pair(story, 0ms, 100, 200);
         story.read(100ms, 1, 4, 10, "x", 300);
         story.read(200ms, 2, 4, 0, "y", 400);
         story.command(300ms, 1, "s", 9);
         story.finish(500ms);
     }},
    {"a transaction that does not end", "transaction_within_f",
     [](Story& story) {
         story.ask(0ms, 1, {3, 0, 0, 0, 2});
         story.engine_ends = false;
         story.look(1s);
     }},
    {"no silence before a request", "silence_kept",
     [](Story& story) {
         read_pair(story, 0ms, 100, 200);
         story.ask(16ms, 1, {4, 0, 10, 0, 1});
     }},
    {"a request while another is under way", "silence_kept",
     [](Story& story) {
         story.ask(0ms, 1, {3, 0, 0, 0, 2});
         story.ask(10ms, 2, {4, 0, 0, 0, 1});
     }},
    {"polling before a command", "order_kept",
     [](Story& story) {
         story.command(10ms, 1, "s", 9);
         read_pair(story, 20ms, 100, 200);
     }},
    {"the longer deadline first", "order_kept",
     [](Story& story) {
         read_pair(story, 0ms, 100, 200);
         story.read(100ms, 1, 4, 10, "x", 300);
         story.read(200ms, 2, 4, 0, "y", 400);
         story.ask(4010ms, 2, {4, 0, 0, 0, 1});
     }},
    {"repeated before what is more urgent", "failed_to_queue",
     [](Story& story) {
         read_pair(story, 0ms, 100, 200);
         story.ask(100ms, 2, {4, 0, 0, 0, 1});
         story.command(110ms, 1, "s", 9);
         story.ask(200ms, 2, {4, 0, 0, 0, 1}, Purpose::repetition);
     }},
    {"a dead device asked too often", "dead_costs_probes",
     [](Story& story) {
         read_pair(story, 0ms, 100, 200);
         story.ask(100ms, 2, {4, 0, 0, 0, 1});
         story.ask(300ms, 2, {4, 0, 0, 0, 1}, Purpose::repetition);
         story.ask(800ms, 2, {4, 0, 0, 0, 1}, Purpose::probe);
     }},
    {"probes, farther and farther apart", "",
     [](Story& story) {
         story.ask(0ms, 1, {3, 0, 0, 0, 2});
         story.ask(100ms, 1, {3, 0, 0, 0, 2}, Purpose::repetition);
         story.ask(1200ms, 1, {3, 0, 0, 0, 2}, Purpose::probe);
         story.ask(3300ms, 1, {3, 0, 0, 0, 2}, Purpose::probe);
     }},
    {"probes that do not become rarer", "dead_costs_probes",
     [](Story& story) {
         story.ask(0ms, 1, {3, 0, 0, 0, 2});
         story.ask(100ms, 1, {3, 0, 0, 0, 2}, Purpose::repetition);
         story.ask(1200ms, 1, {3, 0, 0, 0, 2}, Purpose::probe);
         story.ask(2300ms, 1, {3, 0, 0, 0, 2}, Purpose::probe);
     }},
    {"a probe in spare time", "",
     [](Story& story) {
         story.read(10ms, 2, 4, 0, "y", 400);
         story.ask(100ms, 1, {3, 0, 0, 0, 2});
         story.ask(200ms, 1, {3, 0, 0, 0, 2}, Purpose::repetition);
         story.probe_early(1210ms, 1, {3, 0, 0, 0, 2});
         story.probe_early(2250ms, 1, {3, 0, 0, 0, 2});
     }},
    {"two probes in spare time within a period", "dead_costs_probes",
     [](Story& story) {
         story.read(10ms, 2, 4, 0, "y", 400);
         story.ask(100ms, 1, {3, 0, 0, 0, 2});
         story.ask(200ms, 1, {3, 0, 0, 0, 2}, Purpose::repetition);
         story.probe_early(1210ms, 1, {3, 0, 0, 0, 2});
         story.probe_early(1900ms, 1, {3, 0, 0, 0, 2});
     }},
    {"a probe in spare time before a read that is due", "dead_costs_probes",
     [](Story& story) {
         story.read(10ms, 2, 4, 0, "y", 400);
         story.ask(100ms, 1, {3, 0, 0, 0, 2});
         story.ask(200ms, 1, {3, 0, 0, 0, 2}, Purpose::repetition);
         story.probe_early(3990ms, 1, {3, 0, 0, 0, 2});
     }},
    {"a bit that is safe to repeat is written again beside one that is not", "",
     [](Story& story) {
         story.set(10ms, "a", 1);
         modify_ignored(story, 20ms, 1);
         story.ask(170ms, 3, {3, 0, 40, 0, 1}, Purpose::before_write);
     }},
    {"a bit that is not safe to repeat is written again", "write_done_exact",
     [](Story& story) {
         story.set(10ms, "b", 1);
         modify_ignored(story, 20ms, 2);
         story.ask(170ms, 3, {3, 0, 40, 0, 1}, Purpose::before_write);
     }},
    {"two bits are written again, and one is not safe to repeat", "write_done_exact",
     [](Story& story) {
         story.set(10ms, "a", 1);
         story.set(10ms, "b", 0);  // it has this value already
         modify_ignored(story, 20ms, 1);
         story.ask(170ms, 3, {3, 0, 40, 0, 1}, Purpose::before_write);
     }},
    {"a bit that is not safe to repeat is written again after a failed read", "write_done_exact",
     [](Story& story) {
         story.set(10ms, "b", 1);
         story.ask(20ms, 3, {3, 0, 40, 0, 1}, Purpose::before_write);
         modify_ignored(story, 120ms, 2);
         story.ask(270ms, 3, {3, 0, 40, 0, 1}, Purpose::before_write);
     }},
    {"an old value in a group", "group_whole",
     [](Story& story) {
         read_pair(story, 0ms, 100, 200);
         story.set(300ms, "v", 7);
         story.set(310ms, "v", 8);
         write_pair(story, 320ms, 7, 200);
     }},
    {"a member that was neither set nor read", "group_whole",
     [](Story& story) {
         story.set(10ms, "v", 7);
         write_pair(story, 20ms, 7, 0);
     }},
    {"asked although it is switched off", "poll_enable_obeyed",
     [](Story& story) {
         read_pair(story, 0ms, 100, 200);
         story.read(100ms, 1, 4, 10, "x", 300);
         story.enable(150ms, false);
         story.ask(200ms, 2, {4, 0, 0, 0, 1});
     }},
    {"read twice in a period", "request_was_due",
     [](Story& story) {
         read_pair(story, 0ms, 100, 200);
         read_pair(story, 500ms, 101, 201);
     }},
    {"claimed to be triggered, and nothing rose", "request_was_due",
     [](Story& story) { story.ask(10ms, 1, {3, 0, 0, 0, 2}, Purpose::trigger); }},
    {"claimed to be a repetition, and nothing failed", "request_was_due",
     [](Story& story) {
         read_pair(story, 0ms, 100, 200);
         story.ask(100ms, 1, {3, 0, 0, 0, 2}, Purpose::repetition);
     }},
    {"claimed to be a probe, and the device answers", "request_was_due",
     [](Story& story) { story.ask(10ms, 1, {3, 0, 0, 0, 2}, Purpose::probe); }},
    {"polled although it does not answer", "dead_costs_probes",
     [](Story& story) {
         story.ask(0ms, 1, {3, 0, 0, 0, 2});
         story.ask(100ms, 1, {3, 0, 0, 0, 2}, Purpose::repetition);
         story.ask(1200ms, 1, {3, 0, 0, 0, 2});
     }},
    {"sent after its expiry", "write_done_exact",
     [](Story& story) {
         story.command(0ms, 1, "s", 9, 10ms);
         write_s(story, 20ms, 9);
     }},
    {"not good at the end", "recovers",
     [](Story& story) {
         read_pair(story, 0ms, 100, 200);
         story.read(100ms, 1, 4, 10, "x", 300);
         story.finish(200ms);
     }},
};

TEST(Judge, NamesWhatABadHistoryBreaks) {
    for (const Case& one : kCases) {
        Story story;
        one.play(story);
        EXPECT_EQ(story.complaint(), one.invariant) << one.what << "\n" << story.text();
    }
}

TEST(Judge, ARunThatDoesNotGoOnIsReportedOnce) {
    judge::Complaints complaints;
    judge::Limits limits(complaints);
    for (std::uint64_t i = 0; i < 3 * judge::Limits::kMostSteps; ++i)
        limits.step(Instant{} + Duration(static_cast<std::int64_t>(i % judge::Limits::kMostSteps)) +
                    std::chrono::seconds(static_cast<std::int64_t>(i / (judge::Limits::kMostSteps - 1))));
    EXPECT_FALSE(complaints.any());
    for (std::uint64_t i = 0; i < judge::Limits::kMostSteps; ++i) limits.step(Instant{} + 10s);
    ASSERT_EQ(complaints.all().size(), 1U);
    EXPECT_EQ(complaints.all()[0].invariant, "reachable");
}

TEST(Judge, MemoryThatGrowsIsReported) {
    judge::Complaints complaints;
    judge::Limits limits(complaints);
    EXPECT_FALSE(limits.step(Instant{} + 119s));
    EXPECT_TRUE(limits.step(Instant{} + 120s));
    EXPECT_FALSE(limits.step(Instant{} + 121s));
    limits.end(Instant{} + 10min, 1000, 1000 + judge::Limits::kMostGrowth);
    EXPECT_FALSE(complaints.any());
    limits.end(Instant{} + 10min, 1000, 1001 + judge::Limits::kMostGrowth);
    ASSERT_TRUE(complaints.any());
    EXPECT_EQ(complaints.all()[0].invariant, "memory_bounded");
}

TEST(Judge, EveryInvariantIsBrokenByOneOfTheHistories) {
    std::set<std::string> broken{"reachable", "memory_bounded"};  // above
    for (const Case& one : kCases) broken.insert(one.invariant);
    for (const auto invariant : judge::kInvariants)
        EXPECT_TRUE(broken.contains(std::string(invariant))) << invariant;
}

}  // namespace judge_test
}  // namespace takt::simtest
