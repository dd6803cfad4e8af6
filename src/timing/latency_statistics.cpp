#include "takt/timing/latency_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace takt::timing {

void LatencyStatistics::record(Duration sample) {
    sample = std::max(sample, Duration::zero());
    min_ = count() == 0 ? sample : std::min(min_, sample);
    max_ = std::max(max_, sample);
    add_to_sum(static_cast<std::uint64_t>(sample.count()));
    histogram_.record(sample);
}

void LatencyStatistics::merge(const LatencyStatistics& other) {
    if (other.count() == 0) return;
    min_ = count() == 0 ? other.min_ : std::min(min_, other.min_);
    max_ = std::max(max_, other.max_);
    add_to_sum(other.sum_);
    histogram_.merge(other.histogram_);
}

Duration LatencyStatistics::mean() const {
    return count() == 0 ? Duration::zero() : Duration(static_cast<std::int64_t>(sum_ / count()));
}

Duration LatencyStatistics::percentile(double percent) const {
    if (!(percent > 0)) return min_;
    if (percent >= 100 || count() == 0) return max_;
    const double exact_rank = std::ceil(percent / 100 * static_cast<double>(count()));
    const auto rank = std::clamp(static_cast<std::uint64_t>(exact_rank), std::uint64_t{1}, count());
    return std::min(histogram_.value_at_rank(rank), max_);
}

void LatencyStatistics::add_to_sum(std::uint64_t nanoseconds) {
    const std::uint64_t headroom = std::numeric_limits<std::uint64_t>::max() - sum_;
    sum_ += std::min(nanoseconds, headroom);
}

}  // namespace takt::timing
