#include "takt/serve/echo_filter.hpp"

#include <algorithm>

namespace takt::serve {

void EchoFilter::sent(Bytes frame, Instant window, Duration pause) {
    frame_ = frame;
    matched_ = 0;
    window_ = window;
    pause_ = pause;
}

EchoFilter::Split EchoFilter::split(Instant t, Bytes bytes) {
    if (frame_.empty()) return {{}, bytes};
    const Bytes held = frame_.first(matched_);
    if (t >= window_) {
        const bool same_frame = matched_ > 0 && t <= after(last_match_, pause_);
        reset();
        return {same_frame ? held : Bytes{}, bytes};
    }
    const Bytes expected = frame_.subspan(matched_);
    const auto differs = std::ranges::mismatch(expected, bytes);
    const auto equal = static_cast<std::size_t>(differs.in2 - bytes.begin());
    if (differs.in1 == expected.end()) {
        reset();
        return {{}, bytes.subspan(equal), true};
    }
    if (differs.in2 != bytes.end()) {
        reset();
        return {held, bytes};
    }
    matched_ += equal;
    last_match_ = t;
    return {};
}

}  // namespace takt::serve
