#include "takt/poll/failure_share.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string_view>

namespace takt::poll {
namespace failure_share_test {

using namespace std::chrono_literals;
using enum FailureShare::State;

class Device {
public:
    /// @param pattern  '-' failed, '+' answered
    void run(std::string_view pattern, int times = 1) {
        for (int i = 0; i < times; ++i)
            for (const char c : pattern) share.ended(t += period, c == '+');
    }
    FailureShare share{FailureShare::Of::silence};
    Instant t{1h};
    Duration period = 100ms;
};

TEST(FailureShare, ADeviceThatAnswersSomeRequestsStaysFailing) {
    Device device;
    device.run("+-+--");
    EXPECT_EQ(device.share.state(), steady);
    device.run("+-+--", 2);
    ASSERT_EQ(device.share.state(), failing);
    const auto since = device.share.since();
    for (int i = 0; i < 1000; ++i) {
        device.run("+----+-+--");  // it stops answering, and begins again
        ASSERT_EQ(device.share.since(), since) << "the same one";
    }
}

TEST(FailureShare, ItEndsAfterAWhileWithFewFailures) {
    Device device;
    device.run("+--", 20);
    ASSERT_EQ(device.share.state(), failing);
    device.run("+", 200);
    EXPECT_EQ(device.share.state(), failing) << "20 s";
    device.run("+--", 3);
    device.run("+", 250);
    EXPECT_EQ(device.share.state(), failing) << "the time begins again";
    device.run("+", 90);
    EXPECT_EQ(device.share.state(), steady);
    EXPECT_EQ(device.share.since(), std::nullopt);
}

TEST(FailureShare, AnOutageOrAFewFailuresAreNone) {
    Device device;
    device.run("+", 40);
    device.run("-", 500);
    device.run("+", 3);
    EXPECT_EQ(device.share.state(), steady) << "an outage";
    for (int i = 0; i < 100; ++i) {
        device.run("+", 9);
        device.run("-");
        ASSERT_EQ(device.share.state(), steady) << "one of ten";
    }
}

TEST(FailureShare, ADeviceThatStopsAnsweringIsSilent) {
    Device device;
    device.run("+--", 20);
    device.run("-", 290);
    EXPECT_EQ(device.share.state(), failing);
    device.run("-", 20);
    EXPECT_EQ(device.share.state(), steady);
}

// At each share of failures and each period there is one time of the begin.
TEST(FailureShare, ARandomMixtureIsSteady) {
    std::minstd_rand random(39);
    for (const int percent : {30, 45, 60, 75, 90})
        for (const auto period : {50ms, 1000ms, 10000ms}) {
            Device device;
            device.share = FailureShare(FailureShare::Of::refusal);
            device.period = period;
            const auto run = [&] {
                device.run(std::uniform_int_distribution(1, 100)(random) > percent ? "+" : "-");
            };
            for (int i = 0; i < 200; ++i) run();
            const auto since = device.share.since();
            ASSERT_TRUE(since) << percent << " %";
            for (int i = 0; i < 10000; ++i) {
                run();
                ASSERT_EQ(device.share.since(), since) << percent << " % each " << period.count() << " ms";
            }
            const auto share =
                static_cast<double>(device.share.failed()) / static_cast<double>(device.share.transactions());
            EXPECT_NEAR(100 * share, percent, 2);
        }
}

}  // namespace failure_share_test
}  // namespace takt::poll
