// Whether the responses of a unit are those to its last requests (docs/decisions/0039-surplus-responses.md).
#pragma once

#include <cstdint>
#include <optional>

#include "takt/base/numbers.hpp"
#include "takt/base/time.hpp"
#include "takt/bus/outstanding_responses.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::bus {

/// A number that differs for frames with different bytes, but for one pair in 2^32 (FNV-1a).
[[nodiscard]] std::uint32_t frame_hash(Bytes pdu);

/// A frame that is the response to no request, neither to one in flight nor to one that ended without it.
/// Framing::tcp: one with the transaction id of a request that has ended.
struct SurplusFrame {
    UnitId unit;
    AnswerShape shape;  ///< length 0: an exception
    std::uint32_t hash = 0;
    Instant at;  ///< its last byte
    friend bool operator==(const SurplusFrame&, const SurplusFrame&) = default;
};

/// Finds out since when the responses of one unit may be those to earlier requests. A unit that answers one
/// request after the other, and answers one twice, is one response behind from then on. While it is asked
/// without pause for responses of one shape, nothing shows that.
///
/// It is in step
/// - when no further response came for as long as it takes to send one (Outcome::quiet_at);
/// - when it answered with another shape than before: one that is behind shows the shape before;
/// - when its response repeats the request.
///
/// When none of these happened for kInterval, the next read asks for another shape, or waits until the unit
/// has had that pause. Other units are asked meanwhile.
///
/// A request without its response puts the unit in doubt: a response of that shape may be the one that is
/// missing, though nothing shows it. Each further sign of trouble prolongs it: a response that is ambiguous
/// or late, a surplus one that does not repeat the last one, and an exception. A damaged response has come,
/// and no response comes on a connection that has ended. The doubt ends
/// - with a response of another shape, or one that repeats its request, of a unit that keeps the order;
/// - with a request before which nothing came for a doubt time: every earlier response has come, or is lost;
/// - when as many late responses came as are missing;
/// - a doubt time after the last sign of trouble.
/// The doubt time is eight time-outs. It is at most kInterval for a unit that is known to lose responses and
/// not to be late: sixteen time-outs have passed since the first missing response, and kAlert since a late
/// one.
/// For kAlert after a surplus frame, a response is in doubt until the unit is in step again.
///
/// One owner, one thread.
class StepWatch {
public:
    static constexpr Duration kInterval = wire::kStepCheckInterval;
    /// After a surplus frame, for kAlert. Each one that follows another within kInterval halves it; after
    /// kMostHalvings every response is followed by a pause.
    static constexpr Duration kAlertInterval = std::chrono::milliseconds(200);
    static constexpr unsigned kMostHalvings = 8;
    static constexpr Duration kAlert = std::chrono::minutes(5);

    /// Any outcome of the unit. Those with a response count: Status::ok, exception or ambiguous, and no
    /// broadcast. Those of Status::timeout and unexpected_reply begin the doubt.
    /// @param in_order  the unit answers in order, as far as is known
    void on_outcome(const Outcome& outcome, bool in_order = true);

    /// A response to an earlier request, of that shape, was received at t. A further one may follow it, too.
    void on_late(Instant t, const AnswerShape& shape);

    enum class Proof : std::uint8_t {
        proved,   ///< its response is that to this request, as far as can be known
        waits,    ///< it may be that to an earlier request; nothing shows it yet
        refuted,  ///< a sign of trouble followed
    };
    /// @param read  an outcome of Status::ok, that on_outcome() was called with
    [[nodiscard]] Proof proof(Instant t, const Outcome& read) const;
    /// When proof() of a read that waits changes if nothing happens.
    [[nodiscard]] Instant doubted_until(const Outcome& read) const;

    /// @returns since when responses of that shape may have been those to earlier requests; nothing if the
    ///          frame repeats the last response
    std::optional<Instant> on_surplus(const SurplusFrame& frame);

    /// The earliest start of a read with that response: `t`, or the end of the pause that is due.
    [[nodiscard]] Instant earliest(Instant t, const AnswerShape& shape) const {
        return earliest(t, shape, kInterval);
    }
    /// The same of a relayed request. It leaves the pauses of polling free, so that polling seldom waits.
    [[nodiscard]] Instant earliest_relayed(Instant t, const AnswerShape& shape) const {
        return earliest(t, shape, kInterval / 2);
    }

private:
    [[nodiscard]] Instant earliest(Instant t, const AnswerShape& shape, Duration interval) const;
    void judge(const Outcome& outcome, bool came, bool in_order);
    void end_doubt();
    void note_trouble(Instant t, const AnswerShape& shape);
    [[nodiscard]] Duration doubt_time(Instant t) const;
    [[nodiscard]] bool in_doubt(const AnswerShape& shape) const;
    [[nodiscard]] bool behind(const Outcome& read) const;

    AnswerShape shape_;       // of the last response but exceptions, late or not
    std::uint32_t hash_ = 0;  // of the last response
    Duration pause_{};        // without a response, that shows that none follows
    unsigned in_a_row_ = 0;   // surplus frames, each within kInterval of the one before
    bool drained_ = true;     // no surplus frame since the last pause
    Instant surplus_at_ = Instant::min();
    Instant quiet_at_ = Instant::min();
    Instant in_step_at_ = Instant::min();
    Instant alert_until_ = Instant::min();
    AnswerShape doubtful_;               // the shape in doubt
    bool any_doubtful_ = false;          // several shapes are
    unsigned missing_ = 0;               // since the doubt began, and not come late
    Duration wait_{};                    // of the last request
    Instant late_at_ = Instant::min();   // the last late response
    Instant missing_since_ = kNever;     // the first one
    Instant heard_at_ = Instant::min();  // the last response, or the first request
    Instant trouble_at_ = Instant::min();
    Instant doubted_until_ = Instant::min();
};

}  // namespace takt::bus
