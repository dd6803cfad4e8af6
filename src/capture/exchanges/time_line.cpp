#include "takt/capture/time_line.hpp"

#include <algorithm>

namespace takt::capture {

void TimeLine::Span::add(const Span& other) {
    if (other.count == 0) return;
    min = count == 0 ? other.min : std::min(min, other.min);
    max = std::max(max, other.max);
    count += other.count;
    sum_ns += other.sum_ns;
}

void TimeLine::record(std::int64_t time_ns, Duration sample) {
    if (used_ == 0) begin_ns_ = time_ns;
    const auto since =
        static_cast<std::uint64_t>(std::max(time_ns, begin_ns_)) - static_cast<std::uint64_t>(begin_ns_);
    while (since / static_cast<std::uint64_t>(width_ns_) >= kMost) halve();
    const auto index = static_cast<std::size_t>(since / static_cast<std::uint64_t>(width_ns_));
    sample = std::max(sample, Duration::zero());
    spans_[index].add({1, sample, sample, static_cast<std::uint64_t>(sample.count())});
    used_ = std::max(used_, index + 1);
}

void TimeLine::halve() {
    for (std::size_t i = 0; i < kMost / 2; ++i) {
        Span both = spans_[2 * i];
        both.add(spans_[2 * i + 1]);
        spans_[i] = both;
    }
    std::fill(spans_.begin() + kMost / 2, spans_.end(), Span{});
    used_ = (used_ + 1) / 2;
    width_ns_ *= 2;
}

}  // namespace takt::capture
