// Noise before responses: counted for each device, and reported where it is no single event.
#include <algorithm>

#include "run.hpp"

namespace takt::poll {
namespace {

constexpr std::uint64_t kNoisyAnswers = 3;
constexpr std::uint64_t kOneIn = 100;  // responses

}  // namespace

void LinePoller::Run::check_noise(DeviceRun& device, const bus::Outcome& outcome) {
    if (outcome.noise == 0) return;
    device.least_noise = std::min(device.least_noise, outcome.noise);
    device.most_noise = std::max(device.most_noise, outcome.noise);
    const auto& counters = device.statistics.counters;
    if (counters.noisy_answers < kNoisyAnswers ||
        counters.noisy_answers * kOneIn < counters.answered + counters.exceptions)
        return;
    const bool first = !device.statistics.noise;
    device.statistics.noise = NoiseFinding{.least = device.least_noise, .most = device.most_noise};
    if (first && observer_)
        observer_->on_noise(outcome.ended_at, plan_->line,
                            static_cast<std::size_t>(&device - devices_.data()), *device.statistics.noise);
}

}  // namespace takt::poll
