#include "takt/sim/generator.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace takt::sim {
namespace generator_test {

using namespace std::chrono_literals;
using Motion = model::Generator::Motion;

constexpr Instant kStart{std::chrono::hours(5)};

std::vector<double> values(const model::Generator& settings, std::initializer_list<Duration> moments) {
    Generator generator(settings, kStart);
    std::vector<double> found;
    for (const auto since : moments) found.push_back(generator.at(after(kStart, since)));
    return found;
}

TEST(Generator, Sine) {
    const auto found =
        values({.motion = Motion::sine, .from = 10, .to = 30, .period = 4s}, {0s, 1s, 2s, 3s, 5s});
    const std::vector<double> expected{20, 30, 20, 10, 30};
    for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-9) << i;
}

TEST(Generator, RampAndCounter) {
    EXPECT_EQ(values({.motion = Motion::ramp, .from = 10, .to = 0, .period = 10s}, {0s, 5s, 9s, 10s}),
              (std::vector<double>{10, 5, 1, 10}));
    EXPECT_EQ(values({.motion = Motion::counter, .from = 1, .to = 6, .step = 2, .period = 1s},
                     {0s, 1s, 2500ms, 3s, 4s}),
              (std::vector<double>{1, 3, 5, 1, 3}));
}

TEST(Generator, NothingMovesBeforeItsStart) {
    Generator generator({.motion = Motion::counter, .from = 1, .to = 6, .period = 1s}, kStart);
    EXPECT_EQ(generator.at(Instant{}), 1);
}

RC_GTEST_PROP(Generator, AWalkStaysInItsRangeAndItsSteps, (std::uint64_t seed)) {
    const model::Generator settings{
        .motion = Motion::random_walk, .from = -1, .to = 2, .step = 0.25, .period = 1s, .seed = seed};
    Generator walk(settings, kStart);
    Generator same(settings, kStart);
    double before = walk.at(kStart);
    for (int i = 1; i < 100; ++i) {
        const double now = walk.at(after(kStart, i * 1s));
        RC_ASSERT(now >= -1 && now <= 2);
        RC_ASSERT(std::abs(now - before) <= 0.25);
        before = now;
    }
    RC_ASSERT(same.at(after(kStart, 99s)) == before);
    (void)walk.at(after(kStart, std::chrono::hours(24 * 365)));
}

}  // namespace generator_test
}  // namespace takt::sim
