// A unit that answers in order and often too late, and what the observers of its values see: outputs and
// history read the events of the store, mirrors its slots.
#include <gtest/gtest.h>

#include <deque>
#include <random>
#include <set>

#include "bench.hpp"
#include "takt/bus/step_watch.hpp"

namespace takt::poll {
namespace late_values_test {

using namespace test;

constexpr int kOfRegister = 10'000;

/// Three reads of one shape, of registers that share no other one.
struct Field {
    double lost = 0.1;           // share of the answers
    double late = 1;             // likewise: they take 0.5 to 3 time-outs, the others 0.1
    bool one_at_a_time = false;  // the unit begins with a request when it has answered the one before
    Duration period = 100ms;
    Duration time_out = 100ms;
    std::optional<Duration> max_age;
};

model::Project described(const Field& field) {
    std::vector<Item> items;
    for (int i = 0; i < 3; ++i)
        items.push_back(int16("V" + std::to_string(i), 100 * i).read(3).every(field.period));
    auto made = project({device(1, items)});
    made.lines[0].transport = model::Transport::tcp;
    auto& device = made.lines[0].devices[0];
    device.group_requests = false;
    device.response_timeout = field.time_out;
    for (auto& variable : device.variables) variable.max_age = field.max_age;
    return made;
}

/// The unit. The value of its answer to the n-th request for register i is i * kOfRegister + n.
class Unit {
public:
    Unit(const Field& field, unsigned seed) : field_(field), random_(seed) {}

    void on_request(Instant t, Bytes bytes) {
        const int index = (bytes[2] << 8 | bytes[3]) / 100;
        const auto n = asked_.size();
        asked_.push_back(t);
        if (chance() < field_.lost) return;
        const double time_outs = chance() < field_.late ? 0.5 + 2.5 * chance() : 0.1;
        const auto delay = std::chrono::duration_cast<Duration>(field_.time_out * time_outs);
        busy_ = field_.one_at_a_time ? std::max(t, busy_) + delay : std::max(busy_ + 1us, t + delay);
        const auto value = static_cast<std::uint16_t>(index * kOfRegister + static_cast<int>(n));
        const std::uint8_t pdu[] = {3, 2, static_cast<std::uint8_t>(value >> 8U),
                                    static_cast<std::uint8_t>(value)};
        const auto frame = wire::encode_frame(wire::Framing::rtu, UnitId{1}, 0, pdu);
        coming.emplace_back(busy_, std::vector(frame.begin(), frame.end()));
    }
    /// The n-th request was the last one before t.
    [[nodiscard]] bool last_before(Instant t, std::size_t n) const {
        return n + 1 == asked_.size() || asked_.at(n + 1) >= t;
    }

    std::deque<std::pair<Instant, std::vector<std::uint8_t>>> coming;

private:
    double chance() { return std::uniform_real_distribution<>(0, 1)(random_); }

    Field field_;
    std::mt19937 random_;
    std::vector<Instant> asked_;
    Instant busy_{};
};

/// What observers have seen of one run.
struct Seen {
    int good = 0;
    int wrong = 0;     // good values of another register, or of a request before the last one
    int in_slots = 0;  // the same in a slot
    int backwards = 0;
    int lost = 0;  // responses whose values no observer has seen
    Duration longest_delay{};
};

class Observed {
public:
    Observed(const value::Store& store, const Unit& unit) : store_(store), unit_(unit) {}

    void look(Instant now) {
        while (const auto* event = store_.next_event(cursor_)) take(now, *event);
        for (std::uint32_t i = 0; i < last_.size(); ++i) {
            const auto& slot = store_[value::SlotId{i}];
            const bool good = slot.quality == value::Quality::good;
            if (good && number_of(slot.value) / kOfRegister != static_cast<int>(i)) ++seen.in_slots;
        }
    }
    [[nodiscard]] std::size_t values() const { return values_.size(); }

    Seen seen;

private:
    static int number_of(const value::Value& value) {
        return static_cast<int>(std::get<std::int64_t>(value));
    }

    void take(Instant now, const value::Event& event) {
        const auto index = event.slot.value;
        seen.backwards += event.t < last_.at(index);
        last_.at(index) = event.t;
        if (event.value.index() != 0) values_.insert(number_of(event.value) % kOfRegister);
        if (event.quality != value::Quality::good) return;
        ++seen.good;
        seen.longest_delay = std::max(seen.longest_delay, now - event.good_at.value());
        const int number = number_of(event.value);
        const auto n = static_cast<std::size_t>(number % kOfRegister);
        const bool own = number / kOfRegister == static_cast<int>(index);
        seen.wrong += !own || !unit_.last_before(event.good_at.value(), n);
    }

    const value::Store& store_;
    const Unit& unit_;
    value::EventCursor cursor_;
    std::array<Instant, 3> last_{};
    std::set<int> values_;
};

Seen run(const Field& field, unsigned seed, Duration length) {
    const auto project = described(field);
    const auto plan = plan::make_plan(project);
    Master master(project, plan, {});
    auto& line = master.line(0);
    Unit unit(field, seed);
    Observed observed(master.store(), unit);
    Instant now{};
    const auto transmit = [&] {
        for (Bytes bytes = line.transmit(now); !bytes.empty(); bytes = line.transmit(now))
            unit.on_request(now, bytes);
    };
    line.on_link(now, true);
    transmit();
    while (now < Instant{} + length) {
        const Instant next = unit.coming.empty() ? kNever : unit.coming.front().first;
        now = std::max(now, std::min(line.next_wakeup(), next));
        if (next <= now) {
            const auto bytes = unit.coming.front().second;
            unit.coming.pop_front();
            line.on_bytes(now, bytes);
        } else {
            line.on_tick(now);
        }
        observed.look(now);
        transmit();
    }
    line.end_writes(now);
    observed.look(now);
    observed.seen.lost =
        static_cast<int>(line.statistics(now).counters.time.count()) - static_cast<int>(observed.values());
    return observed.seen;
}

// The first four seeds showed values of other registers as good before they were held back.
TEST(LateValues, NoValueOfAnotherRequestIsEverGoodAndNoneIsLost) {
    constexpr std::pair<Duration, Duration> kTimes[] = {
        {0ms, 100ms}, {100ms, 100ms}, {1000ms, 100ms}, {100ms, 300ms}, {1000ms, 500ms}};
    constexpr unsigned kSeeds[] = {12, 63, 72, 85, 1, 2, 3, 4, 5, 6, 7, 8};
    for (const bool one_at_a_time : {false, true})
        for (const auto& [period, time_out] : kTimes)
            for (const double late : {0.1, 0.4, 1.0}) {
                int good = 0;
                for (const unsigned seed : kSeeds) {
                    const Field field{
                        .late = late, .one_at_a_time = one_at_a_time, .period = period, .time_out = time_out};
                    const auto seen = run(field, seed, 60s);
                    SCOPED_TRACE(testing::Message()
                                 << "seed " << seed << ", late " << late << ", period " << period / 1ms
                                 << ", time-out " << time_out / 1ms << (one_at_a_time ? ", serial" : ""));
                    good += seen.good;
                    ASSERT_EQ(seen.wrong, 0);
                    ASSERT_EQ(seen.in_slots, 0);
                    ASSERT_EQ(seen.backwards, 0);
                    ASSERT_EQ(seen.lost, 0);
                    ASSERT_LE(seen.longest_delay, bus::StepWatch::kInterval + time_out);
                }
                EXPECT_GT(good, 0) << late;
            }
}

// A value may become stale while the read that follows it is in doubt, or is confirmed.
TEST(LateValues, NoneGoesBackBehindALaterMark) {
    for (const Duration max_age : {200ms, 500ms, 1000ms})
        for (const Duration period : {0ms, 100ms, 1000ms})
            for (unsigned seed = 1; seed <= 12; ++seed) {
                const auto seen = run({.late = 0.4, .period = period, .max_age = max_age}, seed, 60s);
                EXPECT_EQ(seen.backwards, 0)
                    << "seed " << seed << ", period " << period / 1ms << ", max_age " << max_age / 1ms;
            }
}

TEST(LateValues, AUnitThatNeverFailedIsNotDelayed) {
    for (const Duration period : {0ms, 100ms}) {
        const auto seen = run({.lost = 0, .late = 0, .period = period}, 1, 60s);
        EXPECT_GT(seen.good, 1000);
        EXPECT_EQ(seen.lost, 0);
        EXPECT_EQ(seen.longest_delay, 0ms);
    }
}

}  // namespace late_values_test
}  // namespace takt::poll
