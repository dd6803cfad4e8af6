// Values that move as a project says: sine, ramp, random walk, counter.
#pragma once

#include <cstdint>

#include "takt/base/time.hpp"
#include "takt/model/source.hpp"
#include "takt/sim/random.hpp"

namespace takt::sim {

/// The value of a model::Generator as a function of time; the same settings give the same values in every
/// run. A walk that nobody looked at for more than kMostSteps of its steps leaves out the rest. One owner.
class Generator {
public:
    static constexpr std::int64_t kMostSteps = 10'000;

    /// @param start  where it begins; earlier moments count as this one
    Generator(const model::Generator& settings, Instant start);

    /// @param t  never before that of an earlier call
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
