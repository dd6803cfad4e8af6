// The member functions of BasicHistogram.
//
// The index of v >= 2^(p + 1) units, where p are the precision bits, is made of its exponent and the p bits
// after its leading one:
//   shift = floor(log2 v) - p,  index = shift * 2^p + (v >> shift)
// v >> shift lies in 2^p..2^(p + 1) - 1, so indices of neighbouring octaves follow each other without a hole,
// and shift 0 covers 0..2^(p + 1) - 1 as well.
#pragma once

#include <algorithm>
#include <bit>

#include "takt/base/assert.hpp"
#include "takt/base/histogram.hpp"

namespace takt {
namespace histogram {

template <class H>
std::size_t index_of(Duration sample, std::int64_t unit_ns) {
    if (sample >= H::kLimit) return H::kBuckets - 1;
    const auto value =
        sample < Duration::zero() ? std::uint64_t{0} : static_cast<std::uint64_t>(sample.count() / unit_ns);
    const int shift = std::max(0, static_cast<int>(std::bit_width(value)) - 1 - H::kPrecisionBits);
    return (static_cast<std::size_t>(shift) << H::kPrecisionBits) + static_cast<std::size_t>(value >> shift);
}

template <class H>
Duration lower_bound(std::size_t index, std::int64_t unit_ns) {
    const std::size_t octave = index >> H::kPrecisionBits;
    const std::size_t shift = octave < 2 ? 0 : octave - 1;
    return Duration((static_cast<std::int64_t>(index - (shift << H::kPrecisionBits)) << shift) * unit_ns);
}

template <class H>
Duration upper_bound(std::size_t index, std::int64_t unit_ns) {
    return index + 1 == H::kBuckets ? Duration::max() : lower_bound<H>(index + 1, unit_ns) - Duration(1);
}

}  // namespace histogram

template <int precision_bits, int limit_bits, std::int64_t unit_ns, template <std::size_t> class Counts>
void BasicHistogram<precision_bits, limit_bits, unit_ns, Counts>::record(Duration sample,
                                                                         std::uint64_t times) {
    if (times == 0) return;
    counts_.add(histogram::index_of<BasicHistogram>(sample, unit_ns), times);
    total_ += times;
}

template <int precision_bits, int limit_bits, std::int64_t unit_ns, template <std::size_t> class Counts>
void BasicHistogram<precision_bits, limit_bits, unit_ns, Counts>::merge(const BasicHistogram& other) {
    for (std::size_t i = 0; i < kBuckets; ++i)
        if (const auto times = other.counts_[i]; times > 0) counts_.add(i, times);
    total_ += other.total_;
}

template <int precision_bits, int limit_bits, std::int64_t unit_ns, template <std::size_t> class Counts>
Duration BasicHistogram<precision_bits, limit_bits, unit_ns, Counts>::value_at_rank(
    std::uint64_t rank) const {
    TAKT_ASSERT(rank >= 1 && rank <= total_);
    std::size_t index = 0;
    for (std::uint64_t seen = counts_[0]; seen < rank; seen += counts_[index]) ++index;
    return histogram::upper_bound<BasicHistogram>(index, unit_ns);
}

template <int precision_bits, int limit_bits, std::int64_t unit_ns, template <std::size_t> class Counts>
auto BasicHistogram<precision_bits, limit_bits, unit_ns, Counts>::bucket(std::size_t index) const -> Bucket {
    TAKT_ASSERT(index < kBuckets);
    return {histogram::lower_bound<BasicHistogram>(index, unit_ns),
            histogram::upper_bound<BasicHistogram>(index, unit_ns), counts_[index]};
}

}  // namespace takt
