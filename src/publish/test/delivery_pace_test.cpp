#include "outputs/delivery_pace.hpp"

#include <gtest/gtest.h>

#include <functional>

namespace takt::publish {
namespace delivery_pace_test {

using namespace std::chrono_literals;

/// An output that makes and delivers samples at rates of its own; its window is full.
struct Rates {
    DeliveryPace pace;
    Instant now{1000s};
    OutputStatus status;

    Rates() {
        status.state = OutputState::delivering;
        status.mqtt.emplace();
        status.mqtt->window = status.mqtt->in_flight = 20;
    }
    /// @returns the last answer
    std::uint64_t run(Duration length, std::uint64_t made_per_s, std::uint64_t delivered_per_s,
                      std::uint64_t moves_per_s = 10) {
        std::uint64_t behind = 0;
        for (const Instant end = now + length; now < end;) {
            now += Duration(1s) / static_cast<int>(moves_per_s);
            status.samples.sampled += made_per_s / moves_per_s;
            status.samples.delivered += delivered_per_s / moves_per_s;
            behind = pace.note(now, status);
        }
        return behind;
    }
};

TEST(DeliveryPace, AnOutputFallsBehindWhereWhatWaitsGrowsTwice) {
    Rates output;
    EXPECT_EQ(output.run(9s, 850, 200), 0U);
    EXPECT_EQ(output.run(2s, 850, 200), 650U);
    EXPECT_EQ(output.run(20s, 850, 200), 650U);
    EXPECT_EQ(output.run(11s, 850, 900), 0U) << "it catches up";
}

TEST(DeliveryPace, AnOutputThatCatchesUpDoesNotFallBehind) {
    Rates output;
    output.status.samples.sampled = 100'000;
    EXPECT_EQ(output.run(60s, 850, 900), 0U);
    EXPECT_EQ(output.run(60s, 850, 840), 0U) << "within the noise";
}

TEST(DeliveryPace, AWindowThatIsNotFullBeginsAnew) {
    Rates output;
    for (int i = 0; i < 5; ++i) {
        EXPECT_EQ(output.run(9s, 850, 200), 0U);
        output.status.mqtt->in_flight = 19;
        EXPECT_EQ(output.run(1s, 850, 850), 0U);
        output.status.mqtt->in_flight = 20;
    }
    output.run(11s, 850, 200);
    output.status.state = OutputState::waiting;
    EXPECT_EQ(output.pace.note(output.now, output.status), 0U) << "the broker is away";
}

// An array moves the cursor once for many samples.
TEST(DeliveryPace, ACursorThatJumpsIsNoFall) {
    Rates output;
    for (int i = 0; i < 20; ++i) {
        EXPECT_EQ(output.run(3s, 850, 0, 10), 0U);
        output.status.samples.delivered = output.status.samples.sampled - (i % 2 == 0 ? 850 : 1700);
    }
}

TEST(DeliveryPace, SamplesThatAQuotaDropsCountAsNotDelivered) {
    Rates output;
    output.status.samples.dropped = 1'000'000;
    EXPECT_EQ(output.run(11s, 850, 200), 650U);
}

}  // namespace delivery_pace_test
}  // namespace takt::publish
