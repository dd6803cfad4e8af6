#include "devices/noise_meter.hpp"

#include <algorithm>

namespace takt::poll {
namespace {

constexpr std::uint64_t kNoisyAnswers = 3;
constexpr std::uint64_t kOneIn = 100;  // responses

}  // namespace

bool NoiseMeter::add(std::uint32_t bytes, const bus::TransactionCounters& counters) {
    if (bytes == 0) return false;
    least_ = std::min(least_, bytes);
    most_ = std::max(most_, bytes);
    if (counters.noisy_answers < kNoisyAnswers ||
        counters.noisy_answers * kOneIn < counters.answered + counters.exceptions)
        return false;
    const bool first = !finding_;
    finding_ = NoiseFinding{.least = least_, .most = most_};
    return first;
}

}  // namespace takt::poll
