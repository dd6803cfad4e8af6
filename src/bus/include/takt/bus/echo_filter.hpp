// The master's own bytes, heard again: two-wire adapters that do not switch their receiver off.
#pragma once

#include "takt/base/engine.hpp"
#include "takt/base/time.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/wire/frame.hpp"

namespace takt::bus {

/// Holds back received bytes as long as they repeat what was sent; a complete repetition is dropped, anything
/// else is released. The normal response to some writes is the request itself: such a repetition is the echo
/// when it was complete before a response could be, or when echoes were seen before; else it is the response.
///
/// Never allocates; one owner, one thread.
class EchoFilter {
public:
    explicit EchoFilter(Echo mode) : mode_(mode) {}

    /// `frame` is being sent and must stay valid until the next arm() or disarm().
    /// @param repeats_itself  the normal response equals the request
    /// @param earliest_response  no response can be complete before this
    void arm(Bytes frame, bool repeats_itself, Instant earliest_response);
    void disarm();

    struct Step {
        std::size_t consumed = 0;  ///< bytes taken from the front of what was given
        Bytes released;     ///< bytes held back before that are to be read after all, in front of the rest
        bool echo = false;  ///< the frame was heard completely and is dropped
    };
    /// @param t  when the last of `bytes` arrived
    Step filter(Instant t, Bytes bytes);

    /// Bytes held back that are to be read after all, because the line fell silent.
    Bytes release();

    [[nodiscard]] bool holding() const { return matched_ > 0; }
    [[nodiscard]] bool seen() const { return seen_; }

private:
    Echo mode_;
    Bytes sent_;
    std::size_t matched_ = 0;
    bool armed_ = false;
    bool repeats_itself_ = false;
    bool seen_ = false;
    Instant earliest_response_{};
};

}  // namespace takt::bus
