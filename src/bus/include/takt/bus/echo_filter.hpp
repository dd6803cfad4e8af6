// The master's own bytes, heard again: two-wire adapters that do not switch their receiver off.
#pragma once

#include "takt/base/engine.hpp"
#include "takt/base/time.hpp"
#include "takt/bus/transaction.hpp"

namespace takt::bus {

/// Holds back received bytes as long as they repeat what was sent; a complete repetition is dropped, anything
/// else is released.
///
/// The normal response to some writes is the request itself. Such a repetition is an echo when the last other
/// requests had one; of several only one may have been spoilt. While none was answered yet, it is one when
/// times are real (Echo::automatic) and it was complete before a response could be. Else it is the response.
///
/// Never allocates; one owner, one thread.
class EchoFilter {
public:
    explicit EchoFilter(Echo mode) : mode_(mode) {}

    /// `frame` is being sent; it must stay valid until the next arm().
    /// @param repeats_itself     the normal response equals the request
    /// @param earliest_response  no response can be complete before this
    void arm(Bytes frame, bool repeats_itself, Instant earliest_response);

    /// The request was answered: what is heard from now on is no echo, and whether there was one is known.
    void answered();

    struct Step {
        std::size_t consumed = 0;  ///< bytes taken from the front of what was given
        Bytes released;     ///< bytes taken now or before that are to be read after all, in front of the rest
        bool echo = false;  ///< the frame was heard completely and is dropped
    };
    /// @param t  when the last of `bytes` arrived
    Step filter(Instant t, Bytes bytes);

    /// A frame that says what the request said was read although its bytes were not those that were sent (a
    /// spoilt start): whether it is the echo, which is then over.
    [[nodiscard]] bool take_repetition(Instant t);

    /// Bytes held back that are to be read after all, because the line fell silent.
    Bytes release();

    [[nodiscard]] bool holding() const { return matched_ > 0; }

private:
    [[nodiscard]] bool is_echo(Instant t) const;

    enum class Known : std::uint8_t { nothing, present, absent };

    Echo mode_;
    Known known_ = Known::nothing;
    int missed_ = 0;  // echoes in a row, where they are known to be
    Bytes sent_;
    std::size_t matched_ = 0;
    bool armed_ = false;
    bool heard_ = false;
    bool repeats_itself_ = false;
    Instant earliest_response_;
};

}  // namespace takt::bus
