// Responses that did not come in time and may still come (docs/decisions/0032-in-step.md).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "takt/base/numbers.hpp"
#include "takt/base/time.hpp"
#include "takt/bus/transaction.hpp"

namespace takt::bus {

/// A response that was received after its transaction had ended.
struct LateResponse {
    UnitId unit;
    AnswerShape shape;  ///< of its request; its function is that of the request
    Instant at;         ///< its last byte
    /// From the end of the request to the first byte of the response. If the unit answered an earlier request
    /// meanwhile, from that answer on: a device that works on one request at a time had not begun before.
    Duration delay{};
    Duration wait{};  ///< Transaction::wait of the request
    /// If it answers the last request that it may answer; `delay` is that of the first one. The true delay is
    /// not shorter.
    Duration least_delay{};
    /// The unit had answered a later request before: it does not answer in order. Responses of this shape
    /// that were received since this instant may have been late ones; nothing if it answered in order.
    std::optional<Instant> out_of_order_since;
    friend bool operator==(const LateResponse&, const LateResponse&) = default;
};

/// The shape of a received response of at least one byte; an exception has the length 0.
[[nodiscard]] AnswerShape frame_shape(Bytes pdu);

/// A late response is waited for, and expected, for this many times the delay of earlier ones of its unit.
inline constexpr int kLatenessFactor = 2;

/// A time-out for a device that answers after `delay`: at least a fifth longer, rounded up to 1, 1.5, 2, 3,
/// 4, 5, 6 or 8 times a power of ten in milliseconds; at most 65535 ms.
[[nodiscard]] Duration advised_timeout(Duration delay);

/// How the response to a request could be mistaken, from the best to the worst.
enum class Ambiguity : std::uint8_t {
    none,       ///< no outstanding response looks alike, or it is remembered only
    passed,     ///< one does, but its unit has answered a later request: it comes only from a unit that does
                ///< not answer in order
    begun,      ///< one does, but its begin has come: its end is lost, if those bytes were no others
    suspected,  ///< one does, but a later response that looks alike was not followed by another one
    doubted,    ///< one does, and it did not come while it was waited for
    held,       ///< one does, and it is still waited for: the request waits
};

/// Whether a frame is a late response.
enum class Lateness : std::uint8_t {
    none,
    in_order,
    out_of_order,  ///< its unit had answered a later request before
};

/// A request that ended without its response. Which responses it is mistaken for is known from unit, function
/// and length; over Framing::tcp from the transaction id.
struct OutstandingResponse {
    enum class Phase : std::uint8_t {
        owed,       ///< it may come
        suspected,  ///< a later response that looks alike was not followed by another one: perhaps it is lost
        passed,     ///< its unit has answered a later request, or it is taken for lost: it hardly comes
        came,       ///< it was received; take_late() has not given it yet
    };

    UnitId unit;
    Phase phase = Phase::owed;
    std::uint16_t wire_id = 0;  ///< Framing::tcp; else 0
    std::uint16_t count = 1;    ///< such responses; the times are those of the last one
    bool in_order = true;       ///< its unit answers requests in their order, as far as is known
    bool overtaken = false;     ///< the response to a later request of its unit came late
    bool out_of_order = false;  ///< Phase::came
    bool misdirected = false;   ///< a frame of another unit came instead, which no request had asked for
    bool begun = false;         ///< it was cut short
    AnswerShape shape;
    std::uint16_t other_length = 0;  ///< of another response that it may be instead; that of `shape`: none
    Instant end;                     ///< of the request, or of the last answer of the unit before its own
    Instant expired_at;              ///< when its transaction ended
    Instant hold_until;              ///< requests that look alike wait until then
    Instant patient_until = Instant::min();  ///< Phase::owed: all requests to the unit wait until then
    Instant expected_until;                  ///< until then two others in doubt do not prove that it was lost
    Instant confirm_until;   ///< Phase::passed: until then responses that look alike are confirmed
    Instant check_at;        ///< Phase::passed: the next response after that is confirmed too
    Instant forget_at;       ///< the response is not expected to come at all after that
    Duration hold{};         ///< Phase::suspected: requests that look alike wait so long again
    Duration wait{};         ///< Transaction::wait
    Duration delay{};        ///< Phase::came
    Duration least_delay{};  ///< Phase::came
    Instant came_at;         ///< Phase::came

    [[nodiscard]] bool outstanding() const { return phase != Phase::came; }
    [[nodiscard]] bool may_be(UnitId of, const AnswerShape& frame) const;
    /// Of a request that looks alike.
    [[nodiscard]] Ambiguity ambiguity(Instant t) const;
};

/// Lends the memory of the responses that are missing. Most lines never need it.
class ResponseMemory {
public:
    /// Called when the first response is missing. @returns at least one element
    [[nodiscard]] virtual std::span<OutstandingResponse> lend() = 0;

protected:
    ~ResponseMemory() = default;
};

/// Decides which requests must wait, and which responses are in doubt, because a late response could be
/// mistaken for theirs; recognises late responses and measures their delay.
///
/// A frame on a serial line does not identify its request; it shows unit, function and length. A response is
/// outstanding from the failure of its request on. Requests whose normal response looks alike wait for it
/// until `hold_until`, and are in doubt after that. It ends
/// - when it comes;
/// - when its unit answers a request that was sent later and is distinguishable: units answer in order. From
///   then on it is `passed`. Responses that look alike are confirmed until `confirm_until`, and it is
///   recognised until `forget_at`: the unit may not keep the order;
/// - when two later responses that look alike were received, both in doubt, and no further frame followed
///   either of them. After the first one it is `suspected`, and requests that look alike wait again: if every
///   response belongs to the request before, the next one comes meanwhile. The second one does not count
///   before `expected_until`.
///
/// One that was cut short is not waited for, and one later response is enough. That one is confirmed, and not
/// in doubt: the missing one follows only if its begin was something else and it is late as well.
///
/// A response that has passed is remembered until `forget_at`. Meanwhile one response that looks alike is
/// confirmed each second. If each belongs to the request before, a further frame follows it.
///
/// If it comes after all, the unit does not answer in order. Those that have passed and are still expected
/// are owed again.
///
/// Responses that repeat their request identify it. An exception identifies its function only. If an
/// exception may be a late one, it ends the current transaction, because it may also be its response. From
/// then on the unit is sent no request whose response looks like one of the two until the other one was
/// received or its time has passed.
///
/// The memory is lent. Of one unit and shape there are at most kAlike entries. Of a serial line, the last one
/// counts further responses. When the memory is full, the oldest response that has passed is forgotten. If
/// there is none, two of one unit and function share an entry, which looks like all their responses. If no
/// unit has two, the oldest of all is forgotten, and every request waits until its `hold_until`. Never
/// allocates; one owner, one thread.
class OutstandingResponses {
public:
    static constexpr std::size_t kAlike = 4;
    /// For how long responses that look alike are confirmed, after a failure or a response in doubt.
    /// @param wait  Transaction::wait
    [[nodiscard]] static constexpr Duration confirmation_time(Duration wait) { return 8 * wait; }

    /// @param on_demand  lends memory where `memory` is empty; nullptr: nothing is remembered then
    explicit OutstandingResponses(std::span<OutstandingResponse> memory, ResponseMemory* on_demand = nullptr)
        : memory_(memory), on_demand_(on_demand) {}

    void add(const OutstandingResponse& response);

    /// An exception ended a transaction of the shape `current` and may have been a late response. Until
    /// `until` the normal response of either may come.
    void expect_either(UnitId unit, const AnswerShape& current, Instant until);

    /// Forgets the responses whose time has passed.
    void expire(Instant t);

    /// Whether a response may still come whose transaction id is easily confused with this one.
    [[nodiscard]] bool expects(std::uint16_t wire_id) const;

    /// A frame was received that answers no request in flight, or a frame followed it that looks alike.
    /// @param shape    of the frame; length 0: an exception
    /// @param wire_id  nothing: the line is serial
    /// @param begin    its first byte
    /// @returns whether it is a late response: the oldest one that it may be. take_late() then gives it
    Lateness settle(UnitId unit, const AnswerShape& shape, std::optional<std::uint16_t> wire_id,
                    Instant begin, Instant end);
    /// Of the last late response that settle() recognised: since its transaction had ended.
    [[nodiscard]] Duration late_by() const { return late_by_; }

    /// `unit` answered the last request. Responses to earlier requests have passed, except those that look
    /// like a response of `shape`.
    /// @param shape  nothing: the response identifies its request, because it repeats it
    void answered(Instant t, UnitId unit, const std::optional<AnswerShape>& shape);

    /// A response of `shape` was received and no further one followed. Those that look alike are suspected
    /// now, or have passed; the one that is missing may be that to the last request, which ended at
    /// `request_end`.
    /// @param in_doubt  it may be one that has passed. Then that to the last request is missing instead, and
    ///                  responses that look alike are confirmed as long again
    void confirmed(Instant t, UnitId unit, const AnswerShape& shape, Instant request_end, bool in_doubt);

    /// Whether an exception to `function` could be a late one.
    [[nodiscard]] bool ambiguous(UnitId unit, std::uint8_t function) const;

    [[nodiscard]] Ambiguity ambiguity(Instant t, UnitId unit, const AnswerShape& shape) const;
    /// Whether ambiguity() may be other than none for some request. O(1).
    [[nodiscard]] bool any_ambiguity(Instant t) const { return size_ > 0 || t < all_wait_until_; }

    /// Whether any response that looks alike is remembered.
    [[nodiscard]] bool remembers(UnitId unit, const AnswerShape& shape) const;
    /// Whether a frame that looks like one of them is rather the response of another unit: one has
    /// OutstandingResponse::misdirected, or nothing of the unit has come for so many requests, and for so
    /// long, that it is dead and not late.
    [[nodiscard]] bool doubtful(Instant t, UnitId unit, const AnswerShape& shape) const;
    /// Whether any response of the unit is remembered.
    [[nodiscard]] bool remembers(UnitId unit) const;

    /// The earliest start of a request with that response; Instant::min() if it need not wait.
    [[nodiscard]] Instant earliest(UnitId unit, const AnswerShape& shape) const;

    /// The late responses that were not taken yet, in the order of their requests.
    [[nodiscard]] std::optional<LateResponse> take_late();

    void clear();
    /// Continues with the state of `other`, as far as the memory suffices.
    void take_over(const OutstandingResponses& other);

private:
    using Phase = OutstandingResponse::Phase;

    [[nodiscard]] std::span<OutstandingResponse> all() { return memory_.first(size_); }
    [[nodiscard]] std::span<const OutstandingResponse> all() const { return memory_.first(size_); }
    [[nodiscard]] bool have_memory();
    OutstandingResponse& in_order_or_passed(OutstandingResponse& found, const AnswerShape& frame);
    void erase(std::size_t index);
    void make_room(Instant now);
    bool merge();
    /// Whether the outstanding responses of the function have the same length.
    [[nodiscard]] bool one_length(UnitId unit, std::uint8_t function) const;
    [[nodiscard]] std::optional<std::size_t> oldest(Phase phase, Instant held_until) const;
    [[nodiscard]] bool silent(Instant t, UnitId unit) const;

    std::span<OutstandingResponse> memory_;
    ResponseMemory* on_demand_;
    std::size_t size_ = 0;
    Instant all_wait_until_ = Instant::min();
    Duration late_by_{};
};

}  // namespace takt::bus
