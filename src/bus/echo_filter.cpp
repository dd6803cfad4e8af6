// Received bytes are compared with the frame that was sent, from its first byte on. As long as they agree
// they are held back: a complete match is the echo and is dropped, and the first difference releases them.
// Only requests whose normal response repeats them need the history (Known): for these a match may be the
// response.
#include "takt/bus/echo_filter.hpp"

#include <algorithm>
#include <utility>

namespace takt::bus {

void EchoFilter::arm(Bytes frame, bool repeats_itself, Instant earliest_response) {
    sent_ = frame;
    matched_ = 0;
    passed_ = 0;
    heard_ = false;
    armed_ = mode_ != Echo::absent;
    repeats_itself_ = repeats_itself;
    earliest_response_ = earliest_response;
}

// One damaged echo does not prove that the line has no echoes: then the next echo would pass for a response.
// Several missing echoes in a row do.
void EchoFilter::answered() {
    constexpr int kGone = 3;
    if (!repeats_itself_) {
        missed_ = heard_ ? 0 : std::min(missed_ + 1, kGone);
        if (heard_)
            known_ = Known::present;
        else if (known_ != Known::present || missed_ == kGone)
            known_ = Known::absent;
    }
    armed_ = false;
    matched_ = 0;
}

bool EchoFilter::is_echo(Instant t) const {
    if (!repeats_itself_) return true;
    if (known_ != Known::nothing) return known_ == Known::present;
    return mode_ == Echo::automatic && t < earliest_response_;
}

std::size_t EchoFilter::noise_before(Bytes bytes) {
    constexpr std::size_t kMostNoise = 8;
    if (!armed_ || matched_ > 0 || sent_.empty()) return 0;
    std::size_t n = 0;
    while (n < bytes.size() && bytes[n] != sent_[0] && passed_ < kMostNoise) {
        ++n;
        ++passed_;
    }
    return n;
}

EchoFilter::Step EchoFilter::filter(Instant t, Bytes bytes) {
    if (!armed_) return {};
    std::size_t n = 0;
    while (n < bytes.size() && matched_ < sent_.size() && bytes[n] == sent_[matched_]) {
        ++n;
        ++matched_;
    }
    if (matched_ == sent_.size() && is_echo(t)) {
        armed_ = false;
        matched_ = 0;
        heard_ = true;
        return {n, {}, true};
    }
    if (n == bytes.size() && matched_ < sent_.size()) return {n, {}, false};
    return {n, release(), false};
}

bool EchoFilter::take_repetition(Instant t) {
    if (mode_ == Echo::absent || heard_ || !is_echo(t)) return false;
    heard_ = true;
    return true;
}

Bytes EchoFilter::release() {
    armed_ = false;
    return sent_.first(std::exchange(matched_, 0));
}

}  // namespace takt::bus
