#include "takt/plan/firmware_estimate.hpp"

#include <gtest/gtest.h>

namespace takt::plan {
namespace firmware_estimate_test {

using namespace std::chrono_literals;

// The LEUART of an EFM32ZG: divider in steps of 1/32, without oversampling.
model::Firmware low_energy() {
    model::Firmware made;
    made.format = {.baud = 9600, .parity = wire::Parity::none};
    made.core_clock = 14'000'000;
    made.wakeup_time = 2us;
    made.uart_clock = made.timer_clock = 32'768;
    made.uart_clock_ppm = made.timer_clock_ppm = 100;
    made.oversampling = 1;
    made.divider_steps = 32;
    made.timer_bits = 24;
    made.request_period = 1s;
    made.active_ua_per_mhz = 100;
    made.sleep_na = 1000;
    return made;
}

TEST(FirmwareEstimate, TakesTheNearestDivider) {
    const auto made = estimate(low_energy());
    EXPECT_DOUBLE_EQ(made.divider, 109.0 / 32);
    EXPECT_NEAR(made.bit_rate, 9619.96, 0.01);
    EXPECT_NEAR(made.rate.greatest, 0.00208 + 0.0001, 1e-5);
    // The last bit of 10 is sampled after 9.5; the edge of the start bit is found within 1/3.413 of a bit.
    EXPECT_NEAR(made.rate.allowed, (0.5 - 9600.0 / 32'768) / 9.5 / 2, 1e-9);
    EXPECT_TRUE(made.holds());

    auto oversampled = low_energy();
    oversampled.uart_clock = 14'000'000;
    oversampled.oversampling = 16;
    oversampled.divider_steps = 4;
    const auto other = estimate(oversampled);
    EXPECT_DOUBLE_EQ(other.divider, 365.0 / 4);
    EXPECT_NEAR(other.divider_error, -0.00114, 1e-5);
    EXPECT_NEAR(other.rate.allowed, (0.5 - 1.0 / 16) / 9.5 / 2, 1e-9);
}

TEST(FirmwareEstimate, ADividerIsOneAtLeast) {
    auto fast = low_energy();
    fast.format.baud = 115'200;
    const auto made = estimate(fast);
    EXPECT_DOUBLE_EQ(made.divider, 1);
    EXPECT_DOUBLE_EQ(made.bit_rate, 32'768);
    EXPECT_EQ(made.rate.allowed, 0) << "fewer than two samples in a bit";
    EXPECT_FALSE(made.rate.holds());
    EXPECT_FALSE(made.holds());
}

TEST(FirmwareEstimate, ParityLeavesLessForEachBit) {
    auto even = low_energy();
    even.format.parity = wire::Parity::even;
    EXPECT_NEAR(estimate(even).rate.allowed, (0.5 - 9600.0 / 32'768) / 10.5 / 2, 1e-9);
    even.uart_clock_ppm = 20'000;
    EXPECT_FALSE(estimate(even).rate.holds());
}

TEST(FirmwareEstimate, CountsTicksOfSilences) {
    const auto made = estimate(low_energy());
    EXPECT_EQ(made.t3_5.ticks, 154U) << "4.5 characters of 34.13 ticks";
    EXPECT_EQ(made.t1_5.ticks, 86U);
    EXPECT_NEAR(made.t3_5.deviation.greatest, 1 / 32'768.0 + 4.6875e-3 * 1e-4, 1e-9);
    EXPECT_NEAR(made.t3_5.deviation.allowed, 0.5 / 960, 1e-9);

    auto coarse = low_energy();
    coarse.timer_clock = 1000;
    EXPECT_FALSE(estimate(coarse).t1_5.deviation.holds()) << "a tick is as long as a character";
    auto narrow = low_energy();
    narrow.timer_clock = 1'000'000;
    narrow.timer_bits = 12;
    EXPECT_FALSE(estimate(narrow).timer_holds());
    EXPECT_FALSE(estimate(narrow).holds());
    narrow.timer_bits = 64;
    EXPECT_TRUE(estimate(narrow).holds());
}

TEST(FirmwareEstimate, ASlowCoreLosesCharacters) {
    auto slow = low_energy();
    slow.core_clock = 32'768;
    EXPECT_FALSE(estimate(slow).character.holds());
}

TEST(FirmwareEstimate, MoreExchangesThanTheLineCarries) {
    auto busy = low_energy();
    busy.registers = 125;
    busy.other_exchanges = 3;
    EXPECT_FALSE(estimate(busy).line.holds()) << "4 exchanges of 283 ms";
}

TEST(FirmwareEstimate, EachCharacterWakesTheCore) {
    const auto own = own_exchange(2);
    EXPECT_EQ(own.interrupts, 8U + 1 + 9);
    const auto foreign = foreign_exchange(2);
    EXPECT_EQ(foreign.interrupts, 8U + 1 + 9 + 1);
    EXPECT_GT(own.instructions, 1000U);

    auto shared = low_energy();
    shared.other_exchanges = 4;
    const auto made = estimate(shared);
    EXPECT_DOUBLE_EQ(made.wakeups, own_exchange(1).interrupts + 4.0 * foreign_exchange(1).interrupts);
}

TEST(FirmwareEstimate, AddsUpCurrents) {
    auto firmware = low_energy();
    const auto idle = estimate(firmware);
    const double active = own_exchange(1).interrupts * (2e-6 + kInterruptCycles / 14e6) +
                          own_exchange(1).instructions * 2 / 14e6;
    EXPECT_NEAR(idle.active, active, 1e-12);
    EXPECT_NEAR(idle.current_ua(), 1400 * active + 1 * (1 - active), 1e-9);
    EXPECT_FALSE(idle.battery_days);

    firmware.uart_na = 500;
    firmware.transceiver_ua = 200;
    firmware.driver_ua = 1000;
    firmware.battery_mah = 1000;
    const auto made = estimate(firmware);
    EXPECT_NEAR(made.sending, 7 / 960.0, 1e-8);
    EXPECT_NEAR(made.current_ua(), idle.current_ua() + 0.5 + 200 + 1000 * made.sending, 1e-6);
    EXPECT_NEAR(*made.battery_days, 1e6 / made.current_ua() / 24, 1e-6);
}

}  // namespace firmware_estimate_test
}  // namespace takt::plan
