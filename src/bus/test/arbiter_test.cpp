// The order of transactions. The time is moved by hand.
#include "takt/bus/arbiter.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <deque>
#include <map>
#include <vector>

namespace takt::bus {
namespace arbiter_test {

using namespace std::chrono_literals;

constexpr Instant at(Duration since_start) {
    return Instant{} + since_start;
}

Arbiter arbiter(std::size_t positions, double utilization = 0.5, bool rounds = false) {
    Arbiter made(1, 100ms, rounds);
    made.set_plan(utilization, positions);
    return made;
}

PolledRead read_of(std::uint64_t job, Duration deadline, Instant since) {
    return {.job = job,
            .period = deadline,
            .allowed = deadline,
            .since = since,
            .rank = job,
            .position = static_cast<std::size_t>(job)};
}

std::optional<std::uint64_t> chosen(Arbiter& arbiter) {
    const auto candidate = arbiter.choose();
    return candidate ? std::optional(candidate->job) : std::nullopt;
}

TEST(Arbiter, ShorterDeadlinesGoFirst) {
    Arbiter line = arbiter(3);
    line.begin();
    line.offer(at(0s), at(0s), line.polled(at(0s), read_of(0, 200ms, at(0s))));
    line.offer(at(0s), at(0s), line.polled(at(0s), read_of(1, 100ms, at(0s))));
    line.offer(at(0s), at(0s), line.polled(at(0s), read_of(2, 100ms, at(0s))));
    EXPECT_EQ(chosen(line), 1U) << "of equal deadlines the first of the plan";
    EXPECT_EQ(line.wakeup(), kNever);
}

TEST(Arbiter, WaitsForTheFirstThatMayStart) {
    Arbiter line = arbiter(2);
    line.begin();
    line.offer(at(0s), at(30ms), line.polled(at(0s), read_of(0, 100ms, at(0s))));
    line.offer(at(0s), at(20ms), line.polled(at(0s), read_of(1, 200ms, at(0s))));
    EXPECT_EQ(chosen(line), std::nullopt);
    EXPECT_EQ(line.wakeup(), at(20ms));
    line.wake_at(at(10ms));
    EXPECT_EQ(line.wakeup(), at(10ms));
    line.begin();
    EXPECT_EQ(line.wakeup(), kNever);
}

// Utilization, waiting time in deadlines, expected class.
TEST(Arbiter, PromotesOverdueReads) {
    struct Row {
        double utilization;
        Duration waited;
        Urgency urgency;
    };
    const Row rows[] = {
        {0.5, 400ms, Urgency::polled},   // exactly four deadlines
        {0.5, 401ms, Urgency::overdue},  //
        {1.0, 101ms, Urgency::polled},   // a plan that holds its periods
        {1.1, 100ms, Urgency::polled},   // exactly one deadline
        {1.1, 101ms, Urgency::overdue},  // a line that is slower than planned
    };
    for (const auto& row : rows) {
        const Arbiter line = arbiter(1, row.utilization);
        const PolledRead read = read_of(0, 100ms, at(0s));
        const Instant t = at(row.waited);
        EXPECT_EQ(line.polled(t, read).urgency, row.urgency) << row.waited.count();
        EXPECT_EQ(line.polled(t, read).late, row.waited > 100ms);
        const Instant changes = line.changes_at(t, read);
        EXPECT_EQ(changes == kNever, row.urgency == Urgency::overdue);
        if (changes != kNever) {
            EXPECT_EQ(line.polled(changes, read).urgency, Urgency::overdue);
            EXPECT_EQ(line.polled(changes - 1ns, read).urgency, Urgency::polled);
        }
    }
}

TEST(Arbiter, OverdueReadsTakeTurns) {
    const Arbiter line = arbiter(2);
    PolledRead first = read_of(0, 100ms, at(0s));
    PolledRead second = read_of(1, 100ms, at(0s));
    first.last_start = at(20ms);
    second.last_start = at(10ms);
    EXPECT_LT(line.polled(at(1s), second).priority(), line.polled(at(1s), first).priority());
}

TEST(Arbiter, PeriodZeroAndSlowedReadsWaitInTheBackground) {
    const Arbiter line = arbiter(2);
    PolledRead fast = read_of(0, 0ms, at(0s));
    fast.last_start = at(5ms);
    EXPECT_EQ(line.polled(at(10s), fast).urgency, Urgency::background);
    EXPECT_FALSE(line.polled(at(10s), fast).late);
    EXPECT_EQ(line.changes_at(at(10s), fast), kNever);
    PolledRead slowed = read_of(1, 1s, at(10s));
    slowed.slowed = true;
    EXPECT_EQ(line.polled(at(10s), slowed).urgency, Urgency::background);
    EXPECT_EQ(line.changes_at(at(10s), slowed), at(14s) + 1ns);
    EXPECT_EQ(line.polled(at(14s) + 1ns, slowed).urgency, Urgency::overdue);
    EXPECT_FALSE(line.polled(at(15s), slowed).late) << "its values are not good anyway";
    EXPECT_EQ(line.probe(at(10s), slowed).urgency, Urgency::background);
    EXPECT_EQ(line.probe(at(15s), slowed).urgency, Urgency::overdue);
}

TEST(Arbiter, RoundsAscendAndBeginAnew) {
    Arbiter line = arbiter(3, 2.0, true);
    const auto next = [&](std::initializer_list<std::uint64_t> due) {
        line.begin();
        for (const auto job : due) {
            line.keep_round();
            line.offer(at(9s), at(9s), line.polled(at(9s), read_of(job, 100ms, at(0s))));
        }
        const auto job = chosen(line);
        if (job) line.advance_round(static_cast<std::size_t>(*job));
        return job;
    };
    EXPECT_EQ(next({0, 1, 2}), 0U) << "however long they have waited";
    EXPECT_EQ(next({0, 1, 2}), 1U);
    EXPECT_EQ(next({0, 2}), 2U);
    EXPECT_EQ(next({0, 1, 2}), 0U);
    EXPECT_EQ(next({}), std::nullopt);
    EXPECT_EQ(next({0, 1, 2}), 0U) << "nothing was due: a new round";
}

TEST(Arbiter, EventsWithADeadlineGoBeforeThoseInTheOrderOfArrival) {
    Arbiter line = arbiter(0);
    line.begin();
    line.offer(at(0s), at(0s), Arbiter::event(1, 10));
    line.offer(at(0s), at(0s), Arbiter::event(2, 9));
    EXPECT_EQ(chosen(line), 2U);
    line.offer(at(0s), at(0s), Arbiter::event(3, 1s, 8));
    line.offer(at(0s), at(0s), Arbiter::event(4, 500ms, 99));
    EXPECT_EQ(chosen(line), 4U);
}

// The line admits one event in 100 ms. Others go in the background, every second transaction.
TEST(Arbiter, DefersEventsThatTheLineDoesNotAdmit) {
    Arbiter line = arbiter(2);
    const auto send = [&](Instant t) {
        line.begin();
        Candidate event = Arbiter::event(7, 1);
        line.defer(t, event);
        line.offer(t, t, event);
        line.offer(t, t, line.polled(t, read_of(0, 0ms, at(0s))));  // period 0
        const auto candidate = *line.choose();
        line.started(candidate);
        bool admitted = false;
        if (candidate.job == 7) {
            line.event_started(t, admitted);
            line.event_ended(t);
            EXPECT_TRUE(admitted);
        }
        return candidate.job;
    };
    EXPECT_EQ(send(at(0ms)), 7U) << "admitted";
    EXPECT_EQ(send(at(1ms)), 0U);
    EXPECT_EQ(send(at(2ms)), 7U) << "the line has nothing else to do";
    EXPECT_EQ(send(at(3ms)), 0U);
    EXPECT_EQ(send(at(200ms)), 7U) << "admitted again";
}

TEST(Arbiter, OfTwoTransactionsOneIsLatePolling) {
    Arbiter line = arbiter(1);
    const auto send = [&](Instant t) {
        line.begin();
        line.offer(t, t, Arbiter::event(7, 50ms, 1));
        line.offer(t, t, line.polled(t, read_of(0, 100ms, at(0s))));
        const auto candidate = *line.choose();
        line.started(candidate);
        return candidate.job;
    };
    EXPECT_EQ(send(at(100ms)), 7U) << "not late";
    EXPECT_EQ(send(at(101ms)), 0U);
    EXPECT_EQ(send(at(102ms)), 7U);
    EXPECT_EQ(send(at(103ms)), 0U);
}

/// A line as an owner drives it, with every candidate offered for each transaction.
class Line {
public:
    struct Read {
        Duration period{};
        Duration deadline{};
        Instant release;
        Instant last_start = Instant::min();
        std::uint64_t sent = 0;
    };
    struct Sent {
        Candidate candidate;
        Instant t;
        std::vector<Candidate> offered;  // those that might start
    };

    Line(std::vector<Read> reads, double utilization, bool rounds)
        : reads_(std::move(reads)), arbiter_(1, 50ms, rounds), rounds_(rounds) {
        arbiter_.set_plan(utilization, reads_.size());
    }

    void arrive(bool limited) { events_.push_back({++order_, limited, false}); }

    /// @param reversed  the candidates are offered in the opposite order
    std::optional<Sent> send(Instant t, Duration takes, bool reversed) {
        arbiter_.begin();
        std::vector<std::pair<Instant, Candidate>> all;
        for (std::size_t i = 0; i < reads_.size(); ++i) {
            const Read& read = reads_[i];
            if (read.release <= t && read.period > 0ms) arbiter_.keep_round();
            all.emplace_back(read.release, arbiter_.polled(t, state(i)));
        }
        for (const auto& event : events_) {
            auto candidate = event.limited ? Arbiter::event(kEvent + event.order, 20ms, event.order)
                                           : Arbiter::event(kEvent + event.order, event.order);
            if (!event.limited) arbiter_.defer(t, candidate);
            all.emplace_back(t, candidate);
        }
        if (reversed) std::ranges::reverse(all);
        Sent sent{.candidate = {}, .t = t, .offered = {}};
        for (const auto& [start, candidate] : all) {
            arbiter_.offer(t, start, candidate);
            if (start <= t) sent.offered.push_back(candidate);
        }
        const auto candidate = arbiter_.choose();
        if (!candidate) return std::nullopt;
        sent.candidate = *candidate;
        start(t, *candidate, takes);
        return sent;
    }

    [[nodiscard]] Instant wakeup() const { return arbiter_.wakeup(); }
    [[nodiscard]] const std::vector<Read>& reads() const { return reads_; }
    [[nodiscard]] std::size_t waiting() const { return events_.size(); }
    static bool is_event(const Candidate& candidate) { return candidate.job >= kEvent; }

private:
    static constexpr std::uint64_t kEvent = 1000;
    struct Event {
        std::uint64_t order = 0;
        bool limited = false;
        bool admitted = false;
    };

    PolledRead state(std::size_t i) const {
        return {.job = i,
                .period = reads_[i].period,
                .allowed = reads_[i].deadline,
                .since = reads_[i].release,
                .last_start = reads_[i].last_start,
                .rank = i,
                .position = i};
    }

    void start(Instant t, const Candidate& candidate, Duration takes) {
        arbiter_.started(candidate);
        if (!is_event(candidate)) {
            Read& read = reads_[candidate.job];
            arbiter_.advance_round(candidate.job);
            read.last_start = t;
            ++read.sent;
            if (read.period > 0ms) read.release += read.period * ((t - read.release) / read.period + 1);
            return;
        }
        const auto event = std::ranges::find(events_, candidate.job - kEvent, &Event::order);
        if (!event->limited) {
            arbiter_.event_started(t, event->admitted);
            arbiter_.event_ended(t + takes);
        }
        events_.erase(event);
    }

    std::vector<Read> reads_;
    std::deque<Event> events_;
    std::uint64_t order_ = 0;
    Arbiter arbiter_;
    bool rounds_;
};

Line random_line(bool rounds) {
    const auto count = *rc::gen::inRange<std::size_t>(1, 8);
    std::vector<Line::Read> reads(count);
    for (auto& read : reads) {
        read.period = Duration(*rc::gen::inRange(0, 6) * 10ms);
        read.deadline = read.period * *rc::gen::inRange(1, 3);
        read.release = at(Duration(*rc::gen::inRange(0, 30) * 1ms));
    }
    return {std::move(reads), *rc::gen::element(0.5, 1.5), rounds};
}

/// What happens between two transactions: events arrive, and one takes so long.
struct Step {
    int unlimited = 0;
    int limited = 0;
    Duration takes{};
};

Step random_step() {
    return {*rc::gen::inRange(0, 3) == 0 ? *rc::gen::inRange(1, 4) : 0, *rc::gen::inRange(0, 4) == 0 ? 1 : 0,
            Duration(*rc::gen::inRange(1, 20) * 1ms)};
}

// For random offers: the arbiter chooses the first candidate, or late polling if the last transaction was not
// polling. It never waits while a candidate may start. The order of the offers does not matter.
RC_GTEST_PROP(ArbiterProperty, SendsTheLeastOrLatePolling, ()) {
    Line line = random_line(*rc::gen::arbitrary<bool>());
    Instant t = at(0s);
    bool polling_was_last = false;
    for (int i = 0; i < 60; ++i) {
        const Step step = random_step();
        for (int n = 0; n < step.unlimited; ++n) line.arrive(false);
        for (int n = 0; n < step.limited; ++n) line.arrive(true);
        Line copy = line;
        const auto sent = line.send(t, step.takes, false);
        const auto again = copy.send(t, step.takes, true);
        RC_ASSERT(sent.has_value() == again.has_value());
        if (!sent) {
            RC_ASSERT(line.waiting() == 0U);
            Instant first = kNever;
            for (const auto& read : line.reads()) first = std::min(first, read.release);
            RC_ASSERT(line.wakeup() == first && first > t);
            t = first;
            continue;
        }
        RC_ASSERT(sent->candidate.job == again->candidate.job);
        const auto least = *std::ranges::min_element(
            sent->offered, {}, [](const Candidate& candidate) { return candidate.priority(); });
        const bool late = std::ranges::any_of(sent->offered, &Candidate::late);
        if (least.urgency < Urgency::overdue && late && !polling_was_last) {
            RC_ASSERT(sent->candidate.late);
        } else {
            RC_ASSERT(sent->candidate.job == least.job);
        }
        polling_was_last = sent->candidate.polling;
        t += step.takes;
    }
}

// However many events keep arriving on a line that is far too slow, every periodic read is sent: at the
// latest when all others were sent since, each with an event before it.
RC_GTEST_PROP(ArbiterProperty, NoPeriodicReadStarves, (bool rounds)) {
    Line line = random_line(rounds);
    const auto periodic =
        std::ranges::count_if(line.reads(), [](const auto& read) { return read.period > 0ms; });
    RC_PRE(periodic > 0);
    Instant t = at(10s);  // all are overdue
    const auto transactions = 20 * static_cast<int>(line.reads().size());
    for (int i = 0; i < transactions; ++i) {
        line.arrive(true);
        line.send(t, 200ms, false);
        t += 200ms;
    }
    for (const auto& read : line.reads()) {
        if (read.period == 0ms) continue;
        RC_ASSERT(read.sent + 2 >= static_cast<std::uint64_t>(transactions / 2 / periodic));
    }
}

// Events without a rate limit of their own cost polling one transaction in 50 ms, however many there are.
RC_GTEST_PROP(ArbiterProperty, EventsBeyondTheRateDoNotDelayPolling, ()) {
    std::vector<Line::Read> reads(2, {.period = 10ms, .deadline = 10ms, .release = at(0s)});
    Line line(std::move(reads), 0.5, false);
    Instant t = at(0s);
    std::vector<Instant> ahead;  // events sent while polling was due
    for (int i = 0; i < 200; ++i) {
        line.arrive(false);
        const auto takes = Duration(*rc::gen::inRange(1, 5) * 1ms);
        const auto sent = line.send(t, takes, false);
        const bool due = std::ranges::any_of(sent->offered, &Candidate::polling);
        if (due && Line::is_event(sent->candidate)) ahead.push_back(t + takes);
        t += takes;
    }
    for (std::size_t i = 1; i < ahead.size(); ++i) RC_ASSERT(ahead[i] - ahead[i - 1] >= 50ms);
    RC_ASSERT(!ahead.empty());
}

// Many reads: the first by a heap of their priorities is the one of all, as long as each is computed again
// when changes_at() has passed.
RC_GTEST_PROP(ArbiterProperty, PrioritiesChangeOnlyWhenAnnounced, ()) {
    const Arbiter line = arbiter(8, *rc::gen::element(0.5, 1.5));
    PolledRead read = read_of(3, Duration(*rc::gen::inRange(0, 50) * 1ms), at(0s));
    read.slowed = *rc::gen::arbitrary<bool>();
    read.last_start = *rc::gen::arbitrary<bool>() ? Instant::min() : at(-5ms);
    const Instant t = at(Duration(*rc::gen::inRange(0, 300) * 1ms));
    const Instant later = t + Duration(*rc::gen::inRange(0, 300) * 1ms);
    const bool changed = line.polled(t, read).priority() != line.polled(later, read).priority();
    RC_ASSERT(changed == (line.changes_at(t, read) <= later));
}

}  // namespace arbiter_test
}  // namespace takt::bus
