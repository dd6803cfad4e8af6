// Requests of many clients on their way to one line, and the answers on their way back.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>

#include "takt/base/engine.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/relay/answer_cache.hpp"
#include "takt/serve/answer.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::relay {

/// The client that sent a request. Only compared and handed back.
struct Requester {
    std::uint32_t server = 0;  ///< whose client
    std::uint64_t client = 0;  ///< within the server: those with equal numbers share one turn
    serve::Token token = 0;    ///< within the server: this request
};

/// How the requests of a server are carried on the line.
struct RequestPolicy {
    Duration cache{};            ///< how old the answer to the same read may be; zero: none is kept for it
    std::uint16_t attempts = 1;  ///< transmissions of a read that nobody answers, at least 1; writes have one
    Duration max_wait = std::chrono::seconds(5);                 ///< for its turn; beyond, it is never sent
    Duration response_timeout = std::chrono::milliseconds(100);  ///< bus::Transaction::wait
};

struct GatewayConfig {
    bool broadcast = true;        ///< unit 0 addresses all units: a serial line, or its frames over TCP
    std::size_t requests = 256;   ///< that wait for the line, of all clients
    std::size_t per_client = 16;  ///< and of one
    std::size_t cached = 64;      ///< answers
};

struct GatewayCounters {
    std::uint64_t asked = 0;
    std::uint64_t sent = 0;    ///< transactions
    std::uint64_t shared = 0;  ///< answered by the transaction of another
    std::uint64_t from_cache = 0;
    std::uint64_t busy = 0;       ///< exception 6: a full queue, or it waited too long
    std::uint64_t refused = 0;    ///< exceptions 1 and 3: not to be passed on
    std::uint64_t no_path = 0;    ///< exception 0x0A
    std::uint64_t no_answer = 0;  ///< exception 0x0B
    std::uint64_t forgotten = 0;  ///< whose client went away
};

/// Gives every request exactly one answer: its own, or an exception.
///
/// Order. A client has one request in the order of the line, those behind it wait in the client's own queue;
/// a request comes into the order at its end. So when a request is in the order, at most one transaction of
/// each other client goes before it, and nothing that is accepted later overtakes it.
///
/// Reads of the same unit with equal bytes are answered together by the first of them, also when it is under
/// way; but no read that came into the order after a write to its unit (or a broadcast) did is answered from
/// before that write, nor from the cache. Writes are never shared and never sent twice; a read that nobody
/// answered goes to the end of the order while it has attempts left.
///
/// Exceptions of its own: 1 and 3 for what must not be passed on (function 0 or above 127, a length that does
/// not fit the function, a broadcast that is no write), 6 when there is no room or its turn did not come
/// within max_wait, 0x0A while the line is not open, 0x0B when the device did not answer, or the line was
/// lost after the request was sent. A broadcast is answered as if one device had: when it was sent.
///
/// Nothing is sent from here: the owner moves transactions between next() and on_outcome() and the line. One
/// owner, one thread. Does not allocate while there are no more requests than there were before.
class Gateway {
public:
    Gateway() : Gateway(GatewayConfig{}) {}
    explicit Gateway(const GatewayConfig& config);

    /// @param request  not empty; also one that could not be decoded
    /// @returns the answer where there is one at once; else take_reply() will have it
    [[nodiscard]] std::optional<wire::Pdu> ask(Instant t, const Requester& requester,
                                               const RequestPolicy& policy, UnitId unit,
                                               const wire::PreparedRequest& request);

    /// Its client is gone. What was not sent is not sent; what is under way is finished, and its answer
    /// thrown away.
    void forget(std::uint32_t server, serve::Token token);

    void on_link(bool up);
    void on_tick(Instant t);
    /// When requests have waited too long.
    [[nodiscard]] Instant next_wakeup() const;

    /// The next transaction, when none is under way; it is to be sent now, or as soon as the line allows.
    [[nodiscard]] std::optional<bus::Transaction> next(Instant t);
    [[nodiscard]] bool under_way() const { return flight_.has_value(); }
    /// Whether next() has one, unless it has waited too long.
    [[nodiscard]] bool has_next() const { return first_in_order() != nullptr; }

    /// What became of the transaction of next(), however long ago.
    void on_outcome(const bus::Outcome& outcome);

    struct Reply {
        std::uint32_t server = 0;
        serve::Token token = 0;
        wire::Pdu pdu;
    };
    /// The next answer that became known. To be called after every other call until there is none.
    [[nodiscard]] std::optional<Reply> take_reply();
    [[nodiscard]] bool has_replies() const { return !answered_.empty(); }

    [[nodiscard]] const GatewayCounters& counters() const { return counters_; }
    /// Requests that have no answer yet.
    [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }

private:
    struct Entry {
        Requester requester;
        RequestPolicy policy;
        UnitId unit;
        wire::PreparedRequest request;
        wire::Pdu answer;  // once there is one
        bool read = false;
        std::uint64_t order = 0;  // 0: behind another one of its client
        std::uint32_t epoch = 0;  // how many writes to its unit were accepted before it
        std::uint16_t failures = 0;
        Instant give_up;
    };
    struct Flight {
        bus::TransactionId id = 0;
        UnitId unit;
        wire::PreparedRequest request;
        bool read = false;
        std::uint64_t order = 0;
        std::uint32_t epoch = 0;
    };
    using Entries = std::list<Entry>;

    [[nodiscard]] std::optional<wire::Pdu> answer_at_once(Instant t, const RequestPolicy& policy, UnitId unit,
                                                          const wire::PreparedRequest& request, bool first);
    void accept(Entry& entry);
    void note_write(UnitId unit);
    void promote(std::uint32_t server, std::uint64_t client);
    [[nodiscard]] const Entry* first_in_order() const;
    [[nodiscard]] bool concerns(const Entry& entry) const;
    void retry_or_give_up(wire::ExceptionCode code);
    void answer_all(Bytes pdu);
    Entries::iterator answer(Entries::iterator entry, Bytes pdu);
    Entries::iterator refuse(Entries::iterator entry, wire::ExceptionCode code);
    [[nodiscard]] wire::Pdu exception(std::uint8_t function, wire::ExceptionCode code);
    void cache(const bus::Outcome& outcome);

    GatewayConfig config_;
    GatewayCounters counters_;
    AnswerCache cache_;
    Entries waiting_;   // in the order of asking
    Entries answered_;  // not taken yet
    Entries spare_;     // to be used again
    std::optional<Flight> flight_;
    std::array<std::uint32_t, 256> epochs_{};
    std::uint64_t last_order_ = 0;
    bus::TransactionId last_id_ = 0;
    bool up_ = false;
};

}  // namespace takt::relay
