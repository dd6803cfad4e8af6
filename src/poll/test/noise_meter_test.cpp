// Noise before responses becomes a finding: by itself, and on a line.
#include "devices/noise_meter.hpp"

#include <gtest/gtest.h>

#include "bench.hpp"

namespace takt::poll::test {
namespace noise_meter_test {

TEST(NoiseMeter, ThreeNoisyResponsesAndOneInAHundredAreAFinding) {
    NoiseMeter meter;
    EXPECT_FALSE(meter.add(2, {.answered = 1, .noisy_answers = 1}));
    EXPECT_FALSE(meter.add(0, {.answered = 2, .noisy_answers = 1}));
    EXPECT_FALSE(meter.add(1, {.answered = 3, .noisy_answers = 2}));
    EXPECT_FALSE(meter.add(1, {.answered = 301, .noisy_answers = 3})) << "fewer than one in a hundred";
    EXPECT_FALSE(meter.finding());
    EXPECT_TRUE(meter.add(1, {.answered = 302, .noisy_answers = 4}));
    EXPECT_EQ(meter.finding(), (NoiseFinding{.least = 1, .most = 2}));
    EXPECT_FALSE(meter.add(5, {.answered = 303, .noisy_answers = 5})) << "it was reported";
    EXPECT_EQ(meter.finding(), (NoiseFinding{.least = 1, .most = 5}));
}

TEST(Noise, ThatComesAgainIsReportedOnce) {
    Bench bench(project({device(1, {int16("a", 0).read(3)}), device(2, {int16("b", 0).read(3)})}));
    bench.players[1].noise = {0x00};
    bench.run_until(10s);
    const auto& line = bench.master.line(0);
    ASSERT_TRUE(line.device(0).noise);
    EXPECT_EQ(*line.device(0).noise, (NoiseFinding{.least = 1, .most = 1}));
    EXPECT_FALSE(line.device(1).noise);
    EXPECT_EQ(line.device(0).counters.noise_bytes, line.device(0).counters.answered);
    EXPECT_EQ(line.statistics(bench.now).counters.noise_bytes, line.device(0).counters.answered);
    EXPECT_EQ(line.device(0).counters.timeouts + line.device(0).counters.checksums, 0U);
    EXPECT_EQ(bench.slot("a").quality, value::Quality::good);
    EXPECT_EQ(bench.observed.noise.size(), 1U);
    bench.players[1].noise = {0xFF, 0xFF, 0x00};
    bench.run_until(20s);
    EXPECT_EQ(*line.device(0).noise, (NoiseFinding{.least = 1, .most = 3}));
    EXPECT_EQ(bench.observed.noise.size(), 1U);
}

TEST(Noise, ASingleGlitchIsOnlyCounted) {
    Bench bench(project({device(1, {int16("a", 0).read(3)})}));
    bench.players[1].noise = {0x00};
    bench.run_until(150ms);
    bench.players[1].noise.clear();
    bench.run_until(10s);
    EXPECT_GE(bench.master.line(0).device(0).counters.noisy_answers, 1U);
    EXPECT_LT(bench.master.line(0).device(0).counters.noisy_answers, 3U);
    EXPECT_FALSE(bench.master.line(0).device(0).noise);
}

}  // namespace noise_meter_test
}  // namespace takt::poll::test
