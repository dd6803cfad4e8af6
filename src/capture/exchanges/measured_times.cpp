#include "takt/capture/measured_times.hpp"

#include <algorithm>
#include <cmath>

#include "takt/base/histogram_definitions.hpp"
#include "takt/base/latency_statistics_definitions.hpp"

namespace takt::capture {

void MeasuredTimes::record(Duration sample) {
    sample = std::max(sample, Duration::zero());
    statistics_.record(sample);
    if (count() <= kExact)
        few_.push_back(sample);
    else if (!few_.empty())
        few_ = {};
}

Duration MeasuredTimes::percentile(double percent) const {
    if (few_.empty()) return statistics_.percentile(percent);
    // Multiplied first: 99.9 / 100 is a little more than 0.999.
    const auto rank = static_cast<std::size_t>(std::ceil(percent * static_cast<double>(few_.size()) / 100));
    auto sorted = few_;
    const auto place =
        sorted.begin() + static_cast<std::ptrdiff_t>(std::clamp<std::size_t>(rank, 1, sorted.size()) - 1);
    std::ranges::nth_element(sorted, place);
    return *place;
}

}  // namespace takt::capture

namespace takt {

template class BasicHistogram<7, 40, 1, capture::BlockCounts>;
template class BasicLatencyStatistics<capture::BlockHistogram>;

}  // namespace takt
