// Which answers a line still owes its master, from the bytes at the master's port alone.
//
// A published good value must equal what its register held at some instant not before the request that the
// value came with. The bytes can also show a master a false history. Then no master could do better, and the
// value is exempt. A value is exempt only if a frame with its unit, function and length came after that
// request, holds the shown value, and one of these holds when it is published:
//
//   copy        no earlier request of that shape is unanswered, and the same frame was received before. It is
//               a copy, or an answer of the past. A true answer would look the same.
//   passed      the unanswered requests of that shape have passed, see below. So their answers count as lost.
//   reordered   as many frames of the shape came as were owed, and the last one is published. The unit has
//               never answered out of order. So the last answer belongs to the last request.
//   shifted     an answer of the unit was exempt before, and since then each request of the unit had the same
//               shape and exactly one frame. So each answer may belong to the request before.
//   expired     the unanswered requests of that shape are older than kForgotten.
//
// No exemption holds for longer than kShifted: the master makes sure once a second that a unit is not one
// answer behind. That is, while each of the last requests of the unit had the same shape and one frame, and
// at least one answer in three was exempt.
//
// In all other cases the master knew that an answer of that shape was owed, and a wrong good value is a
// violation. Each use is counted ("seen.exempt_copy", ...).
//
// A shape is unit, function and length of the answer; of a write also the echoed address and value. A request
// has passed
// - when its unit has answered two later ones of its shape, and no further frame of the shape followed either
//   answer for as long as the unit has usually taken to answer (the median of its last answers), before the
//   next request of the shape;
// - when its unit has answered a later request of another shape, and has never answered out of order;
// - when its unit has answered a later request, and twice its usual lateness (the median of the last three
//   late answers) has passed since the request, but at least 8 of its usual delays;
// - when what answered it may be something else: a frame that was received before, damaged bytes, a frame
//   with the length of another answer, or an exception that may refuse a request that has passed. Its own
//   answer may follow.
// A unit has answered out of order when a frame comes that it owes only for a request that has passed, and
// the same frame was not received before. A frame directly behind other bytes does not show it: the master
// may have missed it.
//
// An answer has come, too, when bytes with a wrong checksum begin like it and are as many. An exception shows
// its function only: of several unanswered requests that have not passed it refuses one that is not known.
// When all of them but one have been answered, it was that one.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "frames.hpp"
#include "takt/base/time.hpp"

namespace takt::judge {

/// How often each of the last frames of a line came, by hash. Allocates.
class RecentFrames {
public:
    void add(std::uint64_t hash) {
        if (hashes_.size() == kMost) {
            const auto oldest = counts_.find(hashes_.front());
            if (--oldest->second == 0) counts_.erase(oldest);
            hashes_.pop_front();
        }
        hashes_.push_back(hash);
        ++counts_[hash];
    }
    [[nodiscard]] std::size_t count(std::uint64_t hash) const {
        const auto found = counts_.find(hash);
        return found == counts_.end() ? 0 : found->second;
    }

private:
    static constexpr std::size_t kMost = 16384;  // frames of minutes

    std::deque<std::uint64_t> hashes_;
    std::unordered_map<std::uint64_t, std::size_t> counts_;
};

/// The answers that are owed on one line, and the exemptions above. Over Modbus TCP nothing is owed: the
/// transaction id tells answers apart. Events must come in the order of their time. One owner, one thread;
/// allocates.
class AnswerLedger {
public:
    /// Longer than any simulated lateness.
    static constexpr Duration kForgotten = std::chrono::minutes(5);

    /// Longer than some checks, which may be misled themselves.
    static constexpr Duration kShifted = std::chrono::seconds(5);

    explicit AnswerLedger(wire::Framing framing);

    void on_sent(Instant t, const Asked& asked);
    void on_heard(Instant t, std::span<const std::uint8_t> bytes);
    /// A new connection: what was owed on the old one hardly comes. The master may still expect it, because
    /// it does not know whether a serial line is behind a gateway.
    void on_connection(Instant t);

    /// Whether an answer to an earlier request than the last one may still come and could be taken for the
    /// answer to `asked`, as far as the bytes show.
    [[nodiscard]] bool doubtful(const Asked& asked) const;

    /// The shape of an answer, as far as unit, function and length show it.
    struct Shape {
        std::uint8_t unit = 0;
        std::uint8_t function = 0;
        std::size_t length = 0;
        auto operator<=>(const Shape&) const = default;
    };
    /// Whether the master may still expect an answer of that shape (docs/guarantees.md, "Late responses"): in
    /// the last 5 minutes a request of it had no answer, or the last one had several. So a request of that
    /// shape may be held, replaced, confirmed and repeated. Length 0: of any length. Function 0: of any.
    [[nodiscard]] bool in_doubt(Instant t, const Shape& shape) const;

    /// Whether the request of another shape that was sent to the unit at `t` may check that it is in step:
    /// those before it had one shape for kCheck.
    /// Or a frame of the unit did not answer the last request, in the last kForgotten.
    [[nodiscard]] bool may_check(Instant t, std::uint8_t number) const;
    static constexpr Duration kCheck = std::chrono::milliseconds(200);

    /// The longest time after its request at which an answer of the unit came that was owed.
    [[nodiscard]] Duration lateness(std::uint8_t number) const;

    /// Frames since the last request that could be the answer to `asked`.
    [[nodiscard]] std::vector<ByteVector> candidates(const Asked& asked) const;

    /// When the last of them came.
    [[nodiscard]] std::optional<Instant> last_candidate(const Asked& asked) const;

    /// The exemption for a wrong value, from a frame that could be the answer to the request of `sent`.
    [[nodiscard]] std::optional<std::string_view> exemption(Instant t, Instant sent, const Asked& asked,
                                                            const ByteVector& published) const;

    /// A wrong value from the answer to that request was exempt.
    void note_exempt(Instant t, const Asked& asked);

    /// The unanswered requests that the answer to the request of `sent` can be mistaken for; empty: none.
    [[nodiscard]] std::string describe(Instant t, Instant sent, const Asked& asked) const;

private:
    /// Later answers that no further frame followed, after which an answer counts as lost.
    static constexpr unsigned kLost = 2;

    struct Owed {
        Instant t;
        std::uint64_t number = 0;  // of the request
        std::uint8_t unit = 0;
        std::uint8_t function = 0;
        std::size_t length = 0;
        ByteVector echo;                      // of a write: the PDU of its answer
        std::optional<Instant> suspected_at;  // a later answer of its shape that may be followed by another
        unsigned unfollowed = 0;              // later answers of its shape with no further frame behind them
        bool overtaken = false;               // a later request of another shape was answered
        [[nodiscard]] bool passed(bool in_order) const {
            return unfollowed >= kLost || (overtaken && in_order);
        }
        bool answered = false;
        bool may_follow = false;  // its own answer, after something that answered it
        bool damaged = false;     // what answered it: perhaps the master still expects it
    };
    struct Heard {
        Instant t;
        std::uint8_t unit = 0;
        ByteVector pdu;
    };

    struct Shift {
        Owed request;         // whose wrong answer was exempt
        Instant since;        // at least one answer in three is exempt
        unsigned others = 0;  // requests since the last exempt answer
    };
    struct Run {
        Owed request;                     // the requests of the unit have had its shape
        Instant since;                    // since then
        Instant before = Instant::max();  // the run before began
    };
    struct Unit {
        std::deque<Owed> owed;                           // in the order of sending
        std::deque<std::vector<std::uint64_t>> refused;  // of each: one was refused, by number
        bool suspects = false;                           // an Owed has suspected_at
        std::deque<Duration> delays;                     // of its last answers
        Duration usual_delay = kUnknownDelay;            // their median
        std::deque<Duration> late_delays;                // of its last late answers
        Instant late_at = Instant::min();                // the last one
        Duration lateness{};                             // the longest
        Duration expected = kConfirmed * kUnknownDelay;  // after it an overtaken request counts as passed
        std::optional<Shift> shifted;
        Run run;
        std::optional<Instant> surplus_at;  // a frame that did not answer the last request
        bool reordered = false;             // has answered out of order

        void note_delay(Duration delay);
        void note_late(const Owed& answered, Instant t);
        [[nodiscard]] bool has_passed(const Owed& each, Instant t) const;

    private:
        void compute_expected();
    };
    static constexpr Duration kUnknownDelay = std::chrono::milliseconds(100);
    static constexpr int kConfirmed = 8;  // usual delays: at least as long as responses are confirmed

    [[nodiscard]] static Owed owed(Instant t, const Asked& asked);
    [[nodiscard]] static bool matches(const Owed& owed, const FoundFrame& frame);
    [[nodiscard]] static bool same_shape(const Owed& a, const Owed& b);
    [[nodiscard]] const Unit& unit(std::uint8_t number) const;
    void forget_since();
    /// @pre last_ is not null
    [[nodiscard]] Owed& last() const { return last_->owed.back(); }
    void take(Instant t, const FoundFrame& frame, bool behind_others);
    void take_late(Instant t, const FoundFrame& frame, bool certain, bool overtaken);
    void take_strays(bool own_came);
    [[nodiscard]] std::size_t frames_for(const Owed& request) const;
    void take_exception(Instant t, const FoundFrame& frame);
    static void settle_refused(Unit& unit);
    void remember(Instant t, const Owed& request, std::size_t came);
    [[nodiscard]] bool begins_like_last(std::size_t added) const;
    [[nodiscard]] bool begins_like(ByteVector begin, std::size_t length, std::size_t added) const;
    void settle_last(Instant t);
    [[nodiscard]] bool seen_before(std::uint8_t unit, const ByteVector& pdu) const;
    [[nodiscard]] bool seen_before(const Owed& request) const;
    static void settle(Unit& unit, Owed& request, bool doubtful);
    static void pass_others(Unit& unit, const Owed& answered);
    [[nodiscard]] bool last_is_answered(Instant t) const;
    void settle_suspected(Instant t, const Owed& next);

    wire::Framing framing_;
    std::map<std::uint8_t, Unit> units_;  // by address. They stay where they are
    Unit* last_ = nullptr;                // of the last request
    ByteVector bytes_;                    // not yet parsed
    ByteVector since_;                    // since the last request and the last pause
    std::uint16_t crc_since_;             // of since_
    Instant heard_at_ = Instant::min();
    Instant left_at_ = Instant::min();  // bytes were received that belong to no frame so far
    std::size_t received_ = 0;          // bytes since the last request
    bool paused_ = false;               // between them
    bool damaged_ = false;              // bytes like the answer to the last request came
    std::uint64_t last_number_ = 0;
    struct Doubt {
        Instant until = Instant::min();  // a request had no answer: it is remembered until then
        bool several = false;            // answers to the last request
    };
    std::map<Shape, Doubt> doubts_;
    std::deque<Heard> heard_;   // since the last request; not yet settled
    std::deque<Heard> strays_;  // of them, with the function of the last request and another length
    RecentFrames past_;
};

}  // namespace takt::judge
