#include "takt/sim/generator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace takt::sim {

Generator::Generator(const model::Generator& settings, Instant start)
    : settings_(settings),
      start_(start),
      random_(settings.seed),
      place_(settings.from + (settings.to - settings.from) / 2) {}

double Generator::at(Instant t) {
    using Motion = model::Generator::Motion;
    const Duration since = std::max(t - start_, Duration::zero());
    const std::int64_t step = since / settings_.period;
    const double turn = static_cast<double>((since % settings_.period).count()) /
                        static_cast<double>(settings_.period.count());
    const double span = settings_.to - settings_.from;
    switch (settings_.motion) {
        case Motion::sine: return settings_.from + span / 2 * (1 + std::sin(2 * std::numbers::pi * turn));
        case Motion::ramp: return settings_.from + span * turn;
        case Motion::random_walk: return walk(step);
        case Motion::counter: return count(step);
    }
    return settings_.from;
}

double Generator::walk(std::int64_t step) {
    for (std::int64_t left = std::min(step - walked_, kMostSteps); left > 0; --left) {
        constexpr std::uint32_t kParts = 2'000'001;
        const double part = static_cast<double>(random_.below(kParts)) / ((kParts - 1) / 2.0) - 1;
        place_ = std::clamp(place_ + settings_.step * part, settings_.from, settings_.to);
    }
    walked_ = step;
    return place_;
}

double Generator::count(std::int64_t step) const {
    const double values = std::floor((settings_.to - settings_.from) / settings_.step) + 1;
    return settings_.from + settings_.step * std::fmod(static_cast<double>(step), values);
}

}  // namespace takt::sim
