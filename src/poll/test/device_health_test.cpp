#include "devices/device_health.hpp"

#include <gtest/gtest.h>

#include "bench.hpp"

namespace takt::poll::test {
namespace device_health_test {

using value::Reason;

constexpr OutcomeClass kOk{Reason::ok, true};
constexpr OutcomeClass kTimeout{Reason::timeout};

/// A device with two attempts and a back-off of 1 s to 4 s that answers.
struct Polled {
    Polled() {
        health.set_reads(true);
        health.enter(at(0s), DeviceState::unknown);
        EXPECT_EQ(end(0s, kOk), DeviceVerdict::answered);
        health.enter(at(0s), DeviceState::answering);
    }
    DeviceVerdict end(Duration t, const OutcomeClass& outcome_class, bool others = false) {
        return health.ended(at(t - 10ms), at(t), outcome_class, others);
    }
    /// Two failed attempts until `t`.
    void lose(Duration t) {
        EXPECT_EQ(end(t - 1s, kTimeout), DeviceVerdict::failed);
        EXPECT_EQ(end(t, kTimeout), DeviceVerdict::lost);
        EXPECT_TRUE(health.enter(at(t), DeviceState::not_answering));
    }
    DeviceHealth health{2, {.first = 1s, .limit = 4s}, true};
};

TEST(DeviceHealth, ADeviceThatIsSwitchedOffIsNotReachable) {
    DeviceHealth health(1, {}, false);
    EXPECT_EQ(health.condition().state, DeviceState::switched_off);
    EXPECT_FALSE(health.reachable());
    EXPECT_EQ(health.unreachable(Reason::link_lost), Reason::switched_off);
    EXPECT_TRUE(health.enable(true));
    EXPECT_FALSE(health.enable(true)) << "it was on already";
    EXPECT_TRUE(health.reachable());
    EXPECT_TRUE(health.enable(false));
    EXPECT_EQ(health.ended(at(0s), at(1s), kOk, false), DeviceVerdict::ignored);
}

TEST(DeviceHealth, AfterItsAttemptsItDoesNotAnswer) {
    Polled device;
    device.lose(10s);
    EXPECT_FALSE(device.health.answering());
    EXPECT_FALSE(device.health.reachable());
    EXPECT_EQ(device.health.unreachable(Reason::link_lost), Reason::not_answering);
    EXPECT_EQ(device.health.condition().failure, Reason::timeout);
    EXPECT_EQ(device.end(12s, kOk), DeviceVerdict::returned);
    EXPECT_EQ(device.health.condition().failure, Reason::ok);
    device.health.restart();
    EXPECT_TRUE(device.health.reachable());
}

TEST(DeviceHealth, WithoutReadsItStaysReachable) {
    Polled device;
    device.health.set_reads(false);
    device.lose(10s);
    EXPECT_FALSE(device.health.answering());
    EXPECT_FALSE(device.health.probed());
    EXPECT_TRUE(device.health.reachable()) << "its writes serve as probes";
}

TEST(DeviceHealth, AnOutageBeginsWithTheFirstFailedAttempt) {
    Polled device;
    device.lose(10s);
    EXPECT_EQ(device.health.condition().outages, 1U);
    EXPECT_EQ(device.health.condition().availability.down_since(), at(9s - 10ms));
    EXPECT_TRUE(device.health.enter(at(20s), DeviceState::link_down));
    EXPECT_EQ(device.health.unreachable(Reason::link_lost), Reason::link_lost);
    EXPECT_EQ(device.health.condition().outages, 1U) << "the same outage";
    EXPECT_FALSE(device.health.enter(at(21s), DeviceState::link_down)) << "no change";
    device.health.enter(at(30s), DeviceState::answering);
    EXPECT_FALSE(device.health.condition().availability.down_since());
}

TEST(DeviceHealth, ALostLinkIsNoFailureOfTheDevice) {
    Polled device;
    for (int i = 0; i < 3; ++i) EXPECT_EQ(device.end(10s, {Reason::link_lost}), DeviceVerdict::ignored);
    EXPECT_EQ(device.health.failures(), 0U);
}

TEST(DeviceHealth, EachFailedProbeDoublesTheBackOff) {
    Polled device;
    device.lose(10s);
    for (const Duration wait : {1s, 2s, 4s, 4s}) {
        EXPECT_EQ(device.health.probe_wait(), wait);
        const Instant probe = device.health.probe_at();
        device.health.read_started(probe, 100ms);
        EXPECT_FALSE(device.health.probes_early());
        EXPECT_EQ(device.health.ended(probe, probe + 1s, kTimeout, false), DeviceVerdict::failed);
    }
}

TEST(DeviceHealth, OfSeveralInFlightOnlyTheLastCounts) {
    Polled device;
    device.lose(10s);
    const Instant probe = device.health.probe_at();
    EXPECT_EQ(device.end(10s, kTimeout, true), DeviceVerdict::failed);
    EXPECT_EQ(device.health.probe_at(), probe);
    EXPECT_EQ(device.end(11s, kTimeout, false), DeviceVerdict::failed);
    EXPECT_GT(device.health.probe_at(), probe);
}

TEST(DeviceHealth, AnEarlyProbeLeavesTheBackOffAsItIs) {
    Polled device;
    device.lose(10s);
    device.end(11s, kTimeout);
    device.end(13s, kTimeout);
    ASSERT_EQ(device.health.probe_wait(), 4s);
    const Instant probe = device.health.probe_at();
    EXPECT_EQ(device.health.early_probe_at(at(13s), 500ms), at(13500ms));
    device.health.read_started(at(13500ms), 500ms);
    EXPECT_TRUE(device.health.probes_early());
    EXPECT_EQ(device.health.probe_at(), probe);
    EXPECT_EQ(device.end(14s, kTimeout), DeviceVerdict::failed);
    EXPECT_EQ(device.health.probe_wait(), 4s);
    EXPECT_FALSE(device.health.probes_early());
    device.health.read_started(at(16500ms), 1s);
    EXPECT_EQ(device.health.probe_at(), at(17500ms)) << "not within a period of the early one";
}

TEST(DeviceHealth, EarlyProbesHaveThePeriodOfTheirRead) {
    Polled device;
    device.lose(10s);
    EXPECT_EQ(device.health.early_probe_at(at(10s), 1s), std::nullopt) << "the back-off is as short";
    device.end(11s, kTimeout);
    ASSERT_EQ(device.health.probe_wait(), 2s);
    EXPECT_EQ(device.health.early_probe_at(at(11s), 1500ms), at(12500ms));
    EXPECT_EQ(device.health.early_probe_at(at(11s), 0ms), at(12s)) << "else the first back-off";
    EXPECT_EQ(device.health.early_probe_at(at(11s), 2s), std::nullopt);
}

TEST(DeviceHealth, AnotherPollerGoesOnWithTheOutage) {
    Polled old;
    old.lose(10s);
    DeviceHealth health(2, {}, true);
    health.set_reads(true);
    EXPECT_TRUE(health.take_over(old.health));
    EXPECT_FALSE(health.reachable());
    EXPECT_EQ(health.probe_at(), at(11s));
    EXPECT_EQ(health.condition().outages, 1U);
    DeviceHealth off(2, {}, false);
    EXPECT_FALSE(off.take_over(old.health)) << "it is switched off now";
    EXPECT_FALSE(off.enabled());
}

}  // namespace device_health_test
}  // namespace takt::poll::test
