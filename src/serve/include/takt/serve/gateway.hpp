// A gateway from many clients to one line.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <optional>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/bus/outcome_status.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/serve/answer.hpp"
#include "takt/serve/answer_cache.hpp"
#include "takt/serve/peer_health.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::serve {

/// The sender of a request. Only compared and returned with the answer.
struct Requester {
    std::uint32_t server = 0;  ///< the server of the client
    std::uint64_t client = 0;  ///< unique within the server; requests of one client are sent one at a time
    serve::Token token = 0;    ///< unique within the server: this request
    std::uint64_t peer = 0;    ///< the address of the client; several clients may have the same
};

/// How requests of a server are handled on the line.
struct RequestPolicy {
    Duration cache{};  ///< greatest age of a cached answer; zero: no caching
    /// Transmissions of an unanswered read, at least 1 (bus::attempts_left); writes have one.
    std::uint16_t attempts = 1;
    Duration max_wait = std::chrono::seconds(5);                 ///< limit of the wait in the queue
    Duration response_timeout = std::chrono::milliseconds(100);  ///< bus::Transaction::wait
};

/// The result of a request on the line.
enum class Fate : std::uint8_t {
    answered,  ///< by the device, also with an exception, or from the cache. A broadcast: it was sent
    unknown,   ///< it was sent, and no valid answer came: the device may have executed it
    not_sent,  ///< it never reached the line
};

struct GatewayConfig {
    bool broadcast = true;        ///< unit 0 addresses all units: a serial line, or its frames over TCP
    std::size_t requests = 256;   ///< limit of waiting requests of all clients
    std::size_t per_client = 16;  ///< limit of waiting requests of one client
    std::size_t cached = 64;      ///< answers
};

struct GatewayCounters {
    std::uint64_t asked = 0;
    std::uint64_t sent = 0;    ///< transactions
    std::uint64_t shared = 0;  ///< answered by the transaction of another
    std::uint64_t from_cache = 0;
    std::uint64_t busy = 0;       ///< exception 6: queue full, or max_wait exceeded
    std::uint64_t refused = 0;    ///< exceptions 1 and 3: invalid requests
    std::uint64_t no_path = 0;    ///< exception 0x0A
    std::uint64_t no_answer = 0;  ///< exception 0x0B
    std::uint64_t not_asked = 0;  ///< of these: without being sent, because the unit does not answer
    std::uint64_t forgotten = 0;  ///< the client disconnected
};

/// Gives every request exactly one answer: the device's, or an exception.
///
/// Order. A client has at most one request in the order of the line; its further requests wait in the
/// client's own queue. Among the requests in the order the peers take turns (start-time fair queueing, Goyal,
/// Vin, Cheng 1996): a peer with many connections gets no more than one with a single connection, and its
/// connections take turns. No read overtakes a write to its unit that entered the order before it.
///
/// When the queue is full, the latest request of the peer that has most in it gives way (exception 6) to one
/// of a peer that has fewer.
///
/// Sharing. One transaction answers all equal reads of a unit, also those that come while it is in flight.
/// But a read that enters the order after a write to its unit (or a broadcast) never gets an answer from
/// before that write, nor from the cache. Writes are never shared and never repeated. An unanswered read goes
/// to the end of the order while it has attempts left.
///
/// Own exceptions:
///   - 1 and 3: invalid requests (function 0 or above 127, a length that does not match the function, a
///     broadcast that is no write);
///   - 6: the queue is full, or the request waited longer than max_wait;
///   - 0x0A: the line is not open;
///   - 0x0B: the device did not answer, or the line was lost after the request was sent.
///
/// Back-off. After three failures in a row a unit counts as not answering the peer that asked, like a device
/// that is polled (bus::Health): its requests to the unit get 0x0B at once until the back-off of 1 s,
/// doubling to 60 s, has passed. Then one is sent as a probe. Any answer to the peer ends the back-off,
/// except the exceptions 10 and 11 of another gateway, which count as failures. A new connection of the line
/// forgets it.
///
/// A broadcast is answered like a successful write, once it is sent.
///
/// The gateway sends nothing itself: the owner moves transactions between next(), the line and on_outcome().
/// One owner, one thread. Allocates only when the number of requests exceeds the previous maximum.
class Gateway {
public:
    Gateway() : Gateway(GatewayConfig{}) {}
    explicit Gateway(const GatewayConfig& config);

    /// @param request  not empty; also one that could not be decoded
    /// @returns the answer where there is one at once; else take_reply() will have it
    [[nodiscard]] std::optional<wire::Pdu> ask(Instant t, const Requester& requester,
                                               const RequestPolicy& policy, UnitId unit,
                                               const wire::PreparedRequest& request);

    /// Whether a request for that unit goes to all units of the line.
    [[nodiscard]] bool broadcasts(UnitId unit) const { return config_.broadcast && unit == kBroadcast; }

    /// The client disconnected. An unsent request is dropped; a transaction in flight is finished and its
    /// answer dropped.
    /// @returns not_sent or unknown; nothing: no such request waits for an answer
    std::optional<Fate> forget(std::uint32_t server, serve::Token token);

    /// Refuses a request that was not sent: take_reply() has the exception.
    /// @returns false: its own transaction is in flight, or no such request waits for an answer
    bool refuse(std::uint32_t server, serve::Token token, wire::ExceptionCode code);

    /// Whether the transaction in flight was made for that request, and not for an earlier one that it
    /// shares.
    [[nodiscard]] bool is_in_flight(std::uint32_t server, serve::Token token) const;

    /// The transaction of next() was taken back before it was sent: its requests wait again, and it has no
    /// outcome.
    void on_withdrawn();

    void on_link(bool up);
    void on_tick(Instant t);
    /// The earliest instant at which a request exceeds max_wait.
    [[nodiscard]] Instant next_wakeup() const;

    /// Whether the line may start a request with that response, and does not hold it back because the
    /// response could be mistaken.
    using MayStart = std::function<bool(UnitId, const bus::AnswerShape&)>;

    /// The next transaction if none is in flight; to be sent as soon as the line allows. One that the line
    /// holds back only if it holds back all; empty: none.
    [[nodiscard]] std::optional<bus::Transaction> next(Instant t, const MayStart& may_start = {});
    /// Whether the line holds back the transaction of next(), but not every other request: it is to be
    /// withdrawn.
    [[nodiscard]] bool should_withdraw(const MayStart& may_start) const;
    [[nodiscard]] bool under_way() const { return flight_.has_value(); }
    /// Whether next() would return one, unless its request has expired.
    [[nodiscard]] bool has_next() const { return first_in_order() != nullptr; }

    /// The outcome of the transaction of next().
    void on_outcome(const bus::Outcome& outcome);

    struct Reply {
        std::uint32_t server = 0;
        serve::Token token = 0;
        wire::Pdu pdu;
        Fate fate = Fate::answered;
    };
    /// The next completed answer. To be called after every other call until it returns nothing.
    [[nodiscard]] std::optional<Reply> take_reply();
    [[nodiscard]] bool has_replies() const { return !answered_.empty(); }

    [[nodiscard]] const GatewayCounters& counters() const { return counters_; }
    /// Requests without an answer yet.
    [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }

private:
    struct Entry {
        Requester requester;
        RequestPolicy policy;
        UnitId unit;
        wire::PreparedRequest request;
        wire::Pdu answer;  // once there is one
        Fate fate = Fate::not_sent;
        bool read = false;
        std::uint64_t order = 0;  // 0: waits for an earlier request of its client
        std::uint64_t turn = 0;   // in order: the least goes first
        std::uint32_t epoch = 0;  // number of writes to its unit accepted before it
        std::uint16_t failures = 0;
        Instant give_up;
    };
    static constexpr std::size_t kServed = 256;
    struct Flight {
        bus::TransactionId id = 0;
        UnitId unit;
        wire::PreparedRequest request;
        bool read = false;
        std::uint64_t order = 0;
        std::uint32_t epoch = 0;
        std::uint64_t peer = 0;
    };
    using Entries = std::list<Entry>;

    [[nodiscard]] std::optional<wire::Pdu> answer_at_once(Instant t, const RequestPolicy& policy, UnitId unit,
                                                          const wire::PreparedRequest& request, bool first);
    void accept(Entry& entry);
    void note_write(UnitId unit);
    void promote(std::uint32_t server, std::uint64_t client);
    [[nodiscard]] bool ready(const Entry& entry) const;
    [[nodiscard]] const Entry* first_in_order(const MayStart& may_start = {}) const;
    [[nodiscard]] std::uint64_t turn_of(std::uint64_t peer) const;
    void note_turn(const Entry& entry);
    [[nodiscard]] bool waits_for_write(const Entry& entry) const;
    [[nodiscard]] bool make_room(std::uint64_t for_peer);
    [[nodiscard]] bool concerns(const Entry& entry) const;
    [[nodiscard]] Entries::iterator find(std::uint32_t server, serve::Token token);
    void retry_or_give_up(StatusCode failure);
    void answer_all(Bytes pdu);
    Entries::iterator answer(Entries::iterator entry, Bytes pdu, Fate fate);
    Entries::iterator refuse(Entries::iterator entry, wire::ExceptionCode code);
    /// @returns how many
    template <class Condition>
    std::size_t refuse_if(const Condition& condition, wire::ExceptionCode code);
    [[nodiscard]] wire::Pdu exception(std::uint8_t function, wire::ExceptionCode code);
    void note_sent();
    void cache(const bus::Outcome& outcome);
    [[nodiscard]] bool backs_off(Instant t, UnitId unit, std::uint64_t peer) const;
    void note_health(const bus::Outcome& outcome, std::uint64_t peer);

    GatewayConfig config_;
    GatewayCounters counters_;
    AnswerCache cache_;
    Entries waiting_;   // in order of arrival
    Entries answered_;  // not taken yet
    Entries spare_;     // reused list nodes
    std::optional<Flight> flight_;
    std::array<std::uint32_t, 256> epochs_{};
    PeerHealth health_;
    std::uint64_t last_order_ = 0;
    std::uint64_t turn_ = 0;             // of the last transaction
    std::vector<std::uint64_t> served_;  // the peers that had it; at most kServed
    bus::TransactionId last_id_ = 0;
    bool up_ = false;
};

}  // namespace takt::serve
