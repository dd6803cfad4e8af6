// A change lies in the interval of its event, whenever in its turnaround the device takes the value.
#include <gtest/gtest.h>

#include <random>

#include "tcp_frames.hpp"

namespace takt::poll {
namespace change_interval_test {

using namespace test;

constexpr Duration kChange = 37ms;  // the value is the number of changes so far

std::int64_t value_at(Instant t) {
    return t.time_since_epoch() / kChange;
}

/// Polls one register over TCP.
class Polled {
public:
    Polled() : project_(described()), plan_(plan::make_plan(project_)), master_(project_, plan_) {
        master_.line(0).on_link(now_, true);
    }

    /// Until the next request. @returns its frame
    std::vector<std::uint8_t> asked() {
        auto& line = master_.line(0);
        for (;;) {
            if (const Bytes bytes = line.transmit(now_); !bytes.empty()) return {bytes.begin(), bytes.end()};
            now_ = std::max(now_, line.next_wakeup());
            line.on_tick(now_);
        }
    }
    void answer(const std::vector<std::uint8_t>& frame, Duration turnaround, std::int64_t value) {
        now_ += turnaround;
        const auto low = static_cast<std::uint8_t>(value & 0xFF);
        const auto high = static_cast<std::uint8_t>(value >> 8 & 0xFF);
        master_.line(0).on_bytes(now_, tcp_response(frame, {3, 2, high, low}));
    }

    Instant now_ = at(1s);
    value::EventCursor cursor_;
    const value::Event* next_event() { return master_.store().next_event(cursor_); }

private:
    static model::Project described() {
        auto made = device(1, {int16("v", 0).read(3).every(50ms)});
        made.response_timeout = 2s;
        return tcp_project({made});
    }

    model::Project project_;
    plan::Plan plan_;
    Master master_;
};

TEST(ChangeInterval, HoldsEachChange) {
    for (const int percent : {0, 50, 100}) {
        std::mt19937 random(static_cast<unsigned>(percent) + 1);
        Polled polled;
        std::optional<std::int64_t> before;
        int changes = 0;
        for (int i = 0; i < 2000; ++i) {
            const auto frame = polled.asked();
            const Duration turnaround = std::chrono::milliseconds(1 + random() % 300);
            polled.answer(frame, turnaround, value_at(polled.now_ + turnaround * percent / 100));
            while (const auto* event = polled.next_event()) {
                if (event->quality != value::Quality::good) continue;
                const auto value = std::get<std::int64_t>(event->value);
                if (before && *before != value) {
                    ASSERT_TRUE(event->good_before);
                    ++changes;
                    EXPECT_GT(Instant{} + (*before + 1) * kChange, *event->good_before) << percent;
                    EXPECT_LE(Instant{} + value * kChange, *event->good_at) << percent;
                }
                before = value;
            }
        }
        EXPECT_GT(changes, 1000);
    }
}

}  // namespace change_interval_test
}  // namespace takt::poll
