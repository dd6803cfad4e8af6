// The bucket is kept as one instant instead of a count: tokens(now) = (now - empty_at) / min_interval,
// capped at burst. That needs no rounding and no periodic refill (GCRA, ITU-T I.371 annex A).
#include "takt/base/token_bucket.hpp"

#include <algorithm>

namespace takt {
namespace {

constexpr std::uint32_t kMaxBurst = 1'000'000;

}  // namespace

Result<TokenBucket> TokenBucket::create(std::uint32_t burst, Duration min_interval) {
    if (burst < 1 || burst > kMaxBurst) return fail(Code::out_of_range, burst, 1, kMaxBurst);
    // The product must fit into an Instant.
    const Duration longest = Duration::max() / 4 / burst;
    if (min_interval <= Duration::zero() || min_interval > longest)
        return fail(Code::out_of_range, min_interval.count(), 1, longest.count());
    return TokenBucket(burst, min_interval);
}

TokenBucket::TokenBucket(std::uint32_t burst, Duration min_interval)
    : min_interval_(min_interval), capacity_(min_interval * burst), empty_at_(Instant::min() + capacity_) {}

bool TokenBucket::admit(Instant now) {
    if (next_admission(now) > now) return false;
    empty_at_ = std::max(empty_at_, now - capacity_) + min_interval_;
    return true;
}

Instant TokenBucket::next_admission(Instant now) const {
    return std::max(now, empty_at_ + min_interval_);
}

}  // namespace takt
