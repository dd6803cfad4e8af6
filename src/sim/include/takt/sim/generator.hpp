// Generators of moving values: sine, ramp, random walk, counter.
#pragma once

#include <cstdint>

#include "takt/base/time.hpp"
#include "takt/model/source.hpp"
#include "takt/sim/random.hpp"

namespace takt::sim {

/// The value of a model::Generator as a function of time; equal settings give equal values in every run.
/// After a pause of more than kMostSteps steps a random walk skips the rest of the pause. One owner.
class Generator {
public:
    static constexpr std::int64_t kMostSteps = 10'000;

    /// @param start  time 0 of the generator; earlier times count as this one
    Generator(const model::Generator& settings, Instant start);

    /// @param t  not before that of an earlier call
    [[nodiscard]] double at(Instant t);

private:
    [[nodiscard]] double walk(std::int64_t step);
    [[nodiscard]] double count(std::int64_t step) const;

    model::Generator settings_;
    Instant start_;
    Random random_;
    std::int64_t walked_ = 0;  // steps
    double place_ = 0;
};

}  // namespace takt::sim
