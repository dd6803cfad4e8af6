#include "compact_times.hpp"

#include <algorithm>
#include <utility>

#include "takt/timing/histogram_definitions.hpp"
#include "takt/timing/latency_statistics_definitions.hpp"

namespace takt::poll {

template <std::size_t buckets>
void CountRange<buckets>::add(std::size_t bucket, std::uint64_t times) {
    const std::size_t step = bucket - bucket % kStep;
    if (counts_.empty()) first_ = step;
    if (step < first_) {
        std::vector<std::uint64_t> counts(first_ - step + counts_.size());
        std::ranges::copy(counts_, counts.begin() + static_cast<std::ptrdiff_t>(first_ - step));
        counts_ = std::move(counts);
        first_ = step;
    } else if (const std::size_t size = step - first_ + kStep; size > counts_.size()) {
        counts_.reserve(size);
        counts_.resize(size);
    }
    counts_[bucket - first_] += times;
}

}  // namespace takt::poll

namespace takt::timing {

template class BasicHistogram<3, 26, 1000, poll::CountRange>;
template class BasicLatencyStatistics<poll::CompactHistogram>;

}  // namespace takt::timing
