// The member functions of BasicLatencyStatistics.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "takt/base/latency_statistics.hpp"

namespace takt {

template <class H>
void BasicLatencyStatistics<H>::record(Duration sample, std::uint64_t times) {
    if (times == 0) return;
    sample = std::max(sample, Duration::zero());
    min_ = count() == 0 ? sample : std::min(min_, sample);
    max_ = std::max(max_, sample);
    add_to_sum(static_cast<std::uint64_t>(sample.count()), times);
    histogram_.record(sample, times);
}

template <class H>
void BasicLatencyStatistics<H>::merge(const BasicLatencyStatistics& other) {
    if (other.count() == 0) return;
    min_ = count() == 0 ? other.min_ : std::min(min_, other.min_);
    max_ = std::max(max_, other.max_);
    add_to_sum(other.sum_, 1);
    histogram_.merge(other.histogram_);
}

template <class H>
Duration BasicLatencyStatistics<H>::mean() const {
    return count() == 0 ? Duration::zero() : Duration(static_cast<std::int64_t>(sum_ / count()));
}

template <class H>
Duration BasicLatencyStatistics<H>::percentile(double percent) const {
    if (!(percent > 0)) return min_;
    if (percent >= 100 || count() == 0) return max_;
    // Multiplied first: 99.9 / 100 is a little more than 0.999.
    const double exact_rank = std::ceil(percent * static_cast<double>(count()) / 100);
    const auto rank = std::clamp(static_cast<std::uint64_t>(exact_rank), std::uint64_t{1}, count());
    return std::min(histogram_.value_at_rank(rank), max_);
}

template <class H>
void BasicLatencyStatistics<H>::add_to_sum(std::uint64_t nanoseconds, std::uint64_t times) {
    const std::uint64_t headroom = std::numeric_limits<std::uint64_t>::max() - sum_;
    sum_ += nanoseconds > 0 && times > headroom / nanoseconds ? headroom : nanoseconds * times;
}

}  // namespace takt
