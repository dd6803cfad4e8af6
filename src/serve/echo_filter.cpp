// Received bytes are compared with the frame just sent. A complete match inside the time window is the echo
// and is removed. A partial match is held back; a pause or a difference ends it, and the held bytes are given
// back. Window: end of transmission + kLatest. If the frame could also be a repeated request, and the line
// has not echoed before, the window is shorter: the time in which a master could not have sent as many
// characters.
#include "takt/serve/echo_filter.hpp"

#include <algorithm>

namespace takt::serve {

void EchoFilter::sent(Bytes frame, bool repeats_request, Instant end) {
    matched_ = 0;
    end_ = end;
    const auto length = static_cast<Duration::rep>(frame.size()) * character_;
    window_ = after(end, repeats_request && !echoes_ ? length : length + kLatest);
    frame_ = frame;
}

EchoFilter::Split EchoFilter::split(Instant t, Bytes bytes) {
    if (frame_.empty()) return {.rest = bytes};
    const Instant begun = t - static_cast<Duration::rep>(bytes.size()) * character_;
    const Bytes held = frame_.first(matched_);
    const Instant held_at = last_match_;
    if (t < window_) {
        if (const auto echo = match(t, bytes)) return *echo;
        if (matched_ > 0 && begun > after(held_at, pause_)) {
            matched_ = 0;
            if (auto echo = match(t, bytes)) {
                echo->replay = held;
                echo->replay_at = held_at;
                return *echo;
            }
        }
    }
    reset();
    if (t > end_) echoes_ = false;
    return {.replay = held, .replay_at = held_at, .rest = bytes};
}

std::optional<EchoFilter::Split> EchoFilter::match(Instant t, Bytes bytes) {
    const Bytes expected = frame_.subspan(matched_);
    const auto differs = std::ranges::mismatch(expected, bytes);
    if (differs.in1 == expected.end()) {
        reset();
        echoes_ = true;
        return Split{.rest = bytes.subspan(expected.size()), .whole_echo = true};
    }
    if (differs.in2 != bytes.end()) return std::nullopt;
    matched_ += bytes.size();
    last_match_ = t;
    return Split{};
}

}  // namespace takt::serve
