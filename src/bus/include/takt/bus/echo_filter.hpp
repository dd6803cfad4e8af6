// Removes the echo of the master's own requests: two-wire adapters may leave their receiver on.
#pragma once

#include "takt/base/engine.hpp"
#include "takt/base/time.hpp"
#include "takt/bus/transaction.hpp"

namespace takt::bus {

/// Holds back received bytes while they repeat the frame that was sent. A complete repetition is dropped, all
/// else is released.
///
/// The normal response to some writes repeats the request. Then the filter decides by its history: if the
/// previous requests had echoes (single damaged ones do not count), the repetition is an echo. Before any
/// request was answered, it is an echo if times are real (Echo::automatic) and it was complete before a
/// response could be. Otherwise it is the response.
///
/// Never allocates; one owner, one thread.
class EchoFilter {
public:
    explicit EchoFilter(Echo mode) : mode_(mode) {}

    /// A frame is sent. `frame` must stay valid until the next arm().
    /// @param repeats_itself     the normal response equals the request
    /// @param earliest_response  no response can be complete before this
    void arm(Bytes frame, bool repeats_itself, Instant earliest_response);

    /// The request was answered: no echo can follow, and it is known whether there was one.
    void answered();

    struct Step {
        std::size_t consumed = 0;  ///< bytes taken from the front of the input
        Bytes released;            ///< bytes taken now or before that are no echo; they precede the rest
        bool echo = false;         ///< a complete echo was dropped
    };
    /// @param t  when the last of `bytes` arrived
    Step filter(Instant t, Bytes bytes);

    /// A frame that decodes to the request was received, though its first bytes were damaged. @returns
    /// whether it is the echo; there is none after it
    [[nodiscard]] bool take_repetition(Instant t);

    /// Bytes at the front of `bytes` that can precede an echo, because it begins differently: noise of the
    /// line driver. The filter lets a few pass and still takes the echo behind them.
    [[nodiscard]] std::size_t noise_before(Bytes bytes);

    /// An echo of the request may still be received.
    [[nodiscard]] bool may_come() const {
        return mode_ != Echo::absent && !heard_ && known_ != Known::absent;
    }

    /// Releases the bytes held back, because the line fell silent.
    Bytes release();

    [[nodiscard]] bool holding() const { return matched_ > 0; }

private:
    [[nodiscard]] bool is_echo(Instant t) const;

    enum class Known : std::uint8_t { nothing, present, absent };

    Echo mode_;
    Known known_ = Known::nothing;
    int missed_ = 0;  // missing echoes in a row, on a line known to have them
    Bytes sent_;
    std::size_t matched_ = 0;
    std::size_t passed_ = 0;  // bytes of noise before the echo
    bool armed_ = false;
    bool heard_ = false;
    bool repeats_itself_ = false;
    Instant earliest_response_;
};

}  // namespace takt::bus
