// The index of a duration v >= 2^8 is made of its exponent and the 7 bits after its leading one:
//   shift = floor(log2 v) - 7,  index = shift * 128 + (v >> shift)
// v >> shift lies in 128..255, so indices of neighbouring octaves follow each other without a hole, and shift
// 0 covers 0..255 as well.
#include "takt/timing/histogram.hpp"

#include <algorithm>
#include <bit>

#include "takt/base/assert.hpp"

namespace takt::timing {
namespace {

constexpr int kPrecision = Histogram::kPrecisionBits;

std::size_t index_of(Duration sample) {
    if (sample >= Histogram::kLimit) return Histogram::kBuckets - 1;
    const auto value =
        sample < Duration::zero() ? std::uint64_t{0} : static_cast<std::uint64_t>(sample.count());
    const int shift = std::max(0, static_cast<int>(std::bit_width(value)) - 1 - kPrecision);
    return (static_cast<std::size_t>(shift) << kPrecision) + static_cast<std::size_t>(value >> shift);
}

Duration lower_bound(std::size_t index) {
    const std::size_t octave = index >> kPrecision;
    const std::size_t shift = octave < 2 ? 0 : octave - 1;
    return Duration(static_cast<std::int64_t>(index - (shift << kPrecision)) << shift);
}

Duration upper_bound(std::size_t index) {
    return index + 1 == Histogram::kBuckets ? Duration::max() : lower_bound(index + 1) - Duration(1);
}

}  // namespace

void Histogram::record(Duration sample) {
    ++counts_[index_of(sample)];
    ++total_;
}

void Histogram::merge(const Histogram& other) {
    for (std::size_t i = 0; i < kBuckets; ++i) counts_[i] += other.counts_[i];
    total_ += other.total_;
}

Duration Histogram::value_at_rank(std::uint64_t rank) const {
    TAKT_ASSERT(rank >= 1 && rank <= total_);
    std::size_t index = 0;
    for (std::uint64_t seen = counts_[0]; seen < rank; seen += counts_[index]) ++index;
    return upper_bound(index);
}

Histogram::Bucket Histogram::bucket(std::size_t index) const {
    TAKT_ASSERT(index < kBuckets);
    return {lower_bound(index), upper_bound(index), counts_[index]};
}

}  // namespace takt::timing
