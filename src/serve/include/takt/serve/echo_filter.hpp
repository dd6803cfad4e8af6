// Own echo on a two-wire line.
#pragma once

#include <cstddef>

#include "takt/base/engine.hpp"
#include "takt/base/time.hpp"

namespace takt::serve {

/// Recognises the frame just sent when the own receiver hears it too.
///
/// Most answers can be nothing else when they come back. But the answer to some writes equals its request,
/// and a master may repeat such a write at once. Then it is the echo when the frame before came back too, or
/// when it is complete before a master could have sent as many characters.
///
/// Bytes that begin like an echo are held back, at most to the end of the window, and given back when they go
/// on otherwise. Never allocates; one owner, one thread.
class EchoFilter {
public:
    /// @param character  time of one character
    /// @param pause      bytes held back are given up when nothing follows them for that long
    EchoFilter(Duration character, Duration pause) : character_(character), pause_(pause) {}

    /// @param frame            what is sent; stays valid and unchanged while it is looked for
    /// @param repeats_request  it could as well be a request
    /// @param end              when its last character is out
    void sent(Bytes frame, bool repeats_request, Instant end);

    struct Split {
        Bytes replay;             ///< bytes held back earlier that are no echo; they come before `rest`
        Bytes rest;               ///< of the bytes given: what is no echo
        bool whole_echo = false;  ///< the frame came back completely
    };
    [[nodiscard]] Split split(Instant t, Bytes bytes);

    /// Looks for nothing any more; what is known of the line stays known.
    void reset() { frame_ = {}; }

private:
    /// How long after its time an adapter may deliver an echo.
    static constexpr Duration kLatest = std::chrono::milliseconds(20);

    Duration character_;
    Duration pause_;
    bool echoes_ = false;  // the last frames that were looked for came back
    Bytes frame_;          // empty: nothing is looked for
    std::size_t matched_ = 0;
    Instant end_;     // of the transmission
    Instant window_;  // an echo is complete before
    Instant last_match_;
};

}  // namespace takt::serve
