// The own echo on a two-wire line.
#pragma once

#include <cstddef>
#include <optional>

#include "takt/base/engine.hpp"
#include "takt/base/time.hpp"

namespace takt::serve {

/// Recognises the frame just sent when the own receiver receives it too.
///
/// Most answers cannot be anything else when they come back. But the answers to some writes equal their
/// request, and a master may repeat such a write at once. Such a frame counts as echo if the previous frame
/// came back too, or if it is complete before a master could have sent as many characters.
///
/// Bytes that begin like an echo are held back, at most until the end of the window, and returned if they
/// turn out to be something else. Never allocates; one owner, one thread.
class EchoFilter {
public:
    /// @param character  time of one character
    /// @param pause      after it the echo may begin anew, behind noise that was held back
    EchoFilter(Duration character, Duration pause) : character_(character), pause_(pause) {}

    /// @param frame            the sent frame; stays valid and unchanged while its echo is expected
    /// @param repeats_request  it equals a possible request
    /// @param end              end of its last character
    void sent(Bytes frame, bool repeats_request, Instant end);

    struct Split {
        Bytes replay;             ///< bytes held back earlier that are no echo; they come before `rest`
        Instant replay_at;        ///< when the last of them was received
        Bytes rest;               ///< the given bytes that are no echo
        bool whole_echo = false;  ///< the frame came back completely
    };
    [[nodiscard]] Split split(Instant t, Bytes bytes);

    /// Expects no echo any more. Whether the line echoes stays known.
    void reset() { frame_ = {}; }

private:
    /// @returns nothing: the bytes do not continue the frame
    [[nodiscard]] std::optional<Split> match(Instant t, Bytes bytes);

    /// How long after its time an adapter may deliver an echo.
    static constexpr Duration kLatest = std::chrono::milliseconds(20);

    Duration character_;
    Duration pause_;
    bool echoes_ = false;  // the previous frame came back
    Bytes frame_;          // empty: no echo is expected
    std::size_t matched_ = 0;
    Instant end_;     // of the transmission
    Instant window_;  // end of the window for the echo
    Instant last_match_;
};

}  // namespace takt::serve
