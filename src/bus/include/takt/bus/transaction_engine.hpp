// The transaction engine of one line or connection. Every master of the program sends through it
// (docs/architecture.md).
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "takt/base/bounded_vector.hpp"
#include "takt/base/engine.hpp"
#include "takt/base/inplace_vector.hpp"
#include "takt/base/result.hpp"
#include "takt/bus/counters.hpp"
#include "takt/bus/echo_filter.hpp"
#include "takt/bus/outstanding_responses.hpp"
#include "takt/bus/step_watch.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/bus/transaction_ids.hpp"
#include "takt/wire/framer.hpp"
#include "takt/wire/traffic.hpp"

namespace takt::bus {

/// One transaction inside an engine, occupied from submit() until its outcome is taken.
class TransactionSlot {
    friend class TransactionCore;
    /// confirming: a response was received that may be that to an earlier request; a further frame is waited
    /// for.
    enum class State : std::uint8_t { empty, waiting, sent, confirming, ended };

    State state = State::empty;
    Status status = Status::ok;
    UnitId unit;
    bool sent_once = false;
    bool out_of_step = false;
    bool broadcast = false;
    bool garbled = false;  // bytes with a wrong checksum were received
    bool in_order = true;
    /// A frame that cannot answer the request and looks like an outstanding response: a late one, if the own
    /// one comes too; else perhaps the own one, damaged.
    struct StrayFrame {
        AnswerShape shape;
        Instant end;
    };
    std::optional<StrayFrame> stray;
    bool unordered = false;           // State::confirming: the last frame need not be the response
    bool shared = false;              // serial line: a frame of another master was received meanwhile
    std::uint32_t noise = 0;          // bytes of noise before the response
    std::optional<Mismatch> instead;  // that was received meanwhile
    std::uint16_t wire_id = 0;        // transaction id of the MBAP header
    std::uint16_t pdu_size = 0;
    std::uint8_t* pdu = nullptr;  // the bytes of the request; once it has ended, of the response
    TransactionId id = 0;
    wire::RequestShape request;   // decoded when the transaction was made
    wire::ResponseView response;  // points to pdu
    Duration wait{};
    Duration late_limit{};
    Duration lateness{};
    Duration patience{};
    Duration longest_delay{};
    Instant submitted_at;
    Instant sent_at;
    Instant request_end;
    Instant deadline;
    Instant received_at;  // State::confirming: the last byte of the last response
    Instant ended_at;
    Instant quiet_at;
    Instant unit_busy_until = Instant::min();  // a late response of its unit was received then
    std::uint64_t order = 0;                   // of the outcomes

    [[nodiscard]] bool open() const { return state != State::empty && state != State::ended; }
    [[nodiscard]] bool in_flight() const { return state == State::sent || state == State::confirming; }
    [[nodiscard]] bool awaits_response() const { return state == State::sent && !broadcast; }
    [[nodiscard]] bool is_cut_short() const { return instead && instead->part == Mismatch::Part::length; }
    /// Has ended, and because of `instead`.
    [[nodiscard]] bool explained() const {
        return status == Status::timeout || (is_cut_short() && status == Status::bad_checksum);
    }
    /// The first part in which a frame of another request differs; without a transaction id: unit or
    /// function.
    [[nodiscard]] Mismatch mismatch(const wire::Frame& came) const;
    [[nodiscard]] Bytes content() const { return {pdu, pdu_size}; }
    [[nodiscard]] AnswerShape shape() const { return answer_shape(request); }
    void fill(Bytes bytes) {
        std::copy(bytes.begin(), bytes.end(), pdu);
        pdu_size = static_cast<std::uint16_t>(bytes.size());
    }
};

/// The memory of an engine. Its owner lends it and knows how much a line needs.
struct TransactionStorage {
    std::span<TransactionSlot> slots;  ///< 1..kMaxInFlight: transactions at a time
    /// For each slot longest_pdu bytes: its request, and then its response.
    std::span<std::uint8_t> pdus;
    std::span<std::uint8_t> sending;             ///< sending_size() bytes: the frame that is sent
    std::span<std::uint8_t> receiving;           ///< receiving_size() bytes: the frame that is received
    std::span<OutstandingResponse> outstanding;  ///< a few; on a serial line better a few for each unit
    /// The longest request or response PDU; only Framing::tcp allows less than wire::kMaxPdu.
    std::size_t longest_pdu = wire::kMaxPdu;
    ResponseMemory* on_demand = nullptr;  ///< lends `outstanding` where it is empty; must outlive the engine

    static constexpr std::size_t sending_size(wire::Framing framing,
                                              std::size_t longest_pdu = wire::kMaxPdu) {
        return wire::frame_length(framing, longest_pdu);
    }
    static constexpr std::size_t receiving_size(wire::Framing framing,
                                                std::size_t longest_pdu = wire::kMaxPdu) {
        return framing == wire::Framing::tcp ? wire::frame_length(framing, longest_pdu)
                                             : wire::Framer::storage_size(framing);
    }
};

/// Sends requests one at a time (Framing::tcp: up to `in_flight`), and gives each exactly one outcome.
///
/// Sending. A request is sent when three conditions hold. The line has been silent for max(t3.5, frame_gap)
/// (RTU on a serial line; else frame_gap) since the last character of any station. The previous request
/// started at least request_gap ago. No response that is waited for can be mistaken for its response
/// (OutstandingResponses).
///
/// Receiving. There is one deadline (Transaction::wait); received bytes do not move it. A frame of another
/// unit, function or transaction id is counted and ignored; if it answers an earlier request, it is a late
/// response, and take_late() gives its delay. The engine decodes a frame of the right unit and
/// function, once. If it answers the request, the outcome carries it decoded. If it does not (byte count,
/// repetition of a write), the transaction ends as unexpected_reply. On a serial line the response is also
/// found behind noise (Framer::expect_response); the noise is counted.
///
/// Bytes with a wrong checksum end the transaction as bad_checksum. If they begin like the response and have
/// its length, it ends with the last one, unless the response may have begun inside them. If they only have
/// its length, it ends at the pause after them (LineConfig::frame_silence). All others end it at the
/// deadline. A late response is expected after every failure, unless the response was received with a wrong
/// checksum.
///
/// In step. If a response is received that could be a late one, the engine waits for a further frame that
/// looks alike: as long as the unit usually takes to answer (Transaction::longest_delay). A later frame
/// replaces the one before, which was late. A frame that is followed by others in the same bytes is confirmed
/// too. The transaction is ok if all outstanding responses that look alike were received, or if those that
/// are missing should have come before (Ambiguity::passed) or were cut short (Ambiguity::begun). Else it ends
/// as ambiguous; so it does if two frames came and the unit does not answer in order, and if a frame comes
/// later than the unit usually answers while one that looks alike is missing.
///
/// A serial broadcast (unit 0) has no response: it is ok after the broadcast turnaround. Over Framing::tcp
/// unit 0 is the server itself.
///
/// When the connection is closed while one request waits for its response, that one ends as closed (or as
/// unexpected_reply if the engine asked for the close because of a wrong header). Of several, each ends as
/// link_lost: which one the peer did not like is not known.
///
/// If other stations leave no silence on the line for a second, a waiting request ends as line_busy.
///
/// The owner calls take_outcome() after each on_link, on_bytes, on_tick and cancel_all until there is none: a
/// transaction occupies its slot until its outcome was taken. Time must not run backwards. One owner, one
/// thread. Never allocates; no I/O.
class TransactionCore : public Engine {
public:
    /// @param storage   must outlive the engine; its slots and LineConfig::in_flight limit the number of
    ///                  transactions at a time
    /// @param observer  notified of every frame; may be nullptr; must outlive the engine
    TransactionCore(const LineConfig& config, const TransactionStorage& storage,
                    wire::TrafficObserver* observer = nullptr);
    TransactionCore(const TransactionCore&) = delete;
    TransactionCore& operator=(const TransactionCore&) = delete;

    void on_link(Instant t, bool up) override;
    void on_close(Instant t) override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    [[nodiscard]] Bytes transmit(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override;

    /// Whether a slot is free and the link is up.
    [[nodiscard]] bool can_submit() const;

    /// Accepts a transaction; transmit() sends it as soon as it may start.
    /// @returns queue_full (transactions at a time); connection_lost; out_of_range for an empty request;
    ///          unsupported (function) for a broadcast that is not a write; too_long (bytes, longest_pdu)
    [[nodiscard]] Result<void> submit(Instant t, const Transaction& transaction);

    /// The earliest start of a request to `unit` with that response, if nothing else happens on the line; may
    /// be in the past. A poller that does not submit before this instant keeps its choice open until then.
    [[nodiscard]] Instant earliest_start(UnitId unit, const AnswerShape& shape) const;

    /// Ends all transactions, sent or not. Late responses of those that were sent are expected.
    void cancel_all(Instant t);

    /// The next outcome, in the order in which the transactions ended.
    [[nodiscard]] std::optional<Outcome> take_outcome();

    /// The next response that was received after its transaction had ended. The engine remembers as many
    /// requests as TransactionStorage::outstanding holds; owners that do not take late responses lose the
    /// oldest.
    [[nodiscard]] std::optional<LateResponse> take_late() { return outstanding_.take_late(); }

    /// The next frame that is the response to no request; Framing::tcp: none. Of more than kMostSurplus that
    /// were not taken the oldest are lost.
    [[nodiscard]] std::optional<SurplusFrame> take_surplus();
    static constexpr std::size_t kMostSurplus = 4;

    /// Whether the response to a request could be mistaken for another one. Framing::tcp: none.
    [[nodiscard]] Ambiguity ambiguity(Instant t, UnitId unit, const AnswerShape& shape) const;
    /// Whether ambiguity() may be other than none for some request. O(1).
    [[nodiscard]] bool any_ambiguity(Instant t) const { return !numbered() && outstanding_.any_ambiguity(t); }
    /// Whether a response of the unit is missing: the next one need not belong to the last request.
    [[nodiscard]] bool remembers(UnitId unit) const { return outstanding_.remembers(unit); }

    /// How many requests were sent and wait for their responses.
    [[nodiscard]] std::size_t responses_awaited() const;
    /// One of them.
    struct Awaited {
        TransactionId id = 0;
        UnitId unit;
        Instant sent_at;
    };
    [[nodiscard]] std::optional<Awaited> awaited() const;

    /// No transaction waits or is in flight, and no outcome is left.
    [[nodiscard]] bool idle() const;

    /// Continues where `other` is: link, counters, silences, missing responses. Both are idle and have the
    /// same framing.
    void take_over(const TransactionCore& other);

    [[nodiscard]] bool link_up() const { return link_up_; }
    /// The byte stream has lost its frames (a wrong MBAP header): the owner must reconnect.
    [[nodiscard]] bool must_reconnect() const { return must_reconnect_; }
    /// On this connection something else than an MBAP header was received.
    [[nodiscard]] bool bad_header() const { return bad_header_; }
    [[nodiscard]] std::optional<Error> rejection() const override;
    [[nodiscard]] const LineCounters& counters() const { return counters_; }
    [[nodiscard]] const LineConfig& config() const { return config_; }
    /// The least silence before a request.
    [[nodiscard]] Duration silence() const { return silence_; }

private:
    using Slot = TransactionSlot;
    using State = TransactionSlot::State;
    static constexpr std::size_t kMostRejected = 8;

    void notice_silence(Instant t);
    void notice_deadlines(Instant t);
    void note_activity(Instant t, std::size_t bytes);
    [[nodiscard]] bool numbered() const { return config_.framing == wire::Framing::tcp; }
    [[nodiscard]] bool all_came(const Slot& slot) const;
    void read(Instant t, Bytes bytes);
    void reject(HeaderFault fault, Bytes beginning, Bytes rest = {});
    [[nodiscard]] HeaderFault header_fault(Bytes header) const;
    void handle(Instant t, const wire::FramerStep& step);
    void on_frame(Instant t, const wire::Frame& frame);
    void notify(Instant t, UnitId unit, wire::Incident incident, Duration after = {},
                const std::optional<Mismatch>& instead = {});
    void on_fault(Instant t, const wire::FramerStep& step);
    [[nodiscard]] bool may_be_echo(Instant t, const Slot& slot, std::size_t bytes) const;
    void find_response(Instant t);
    Slot* addressee(const wire::Frame& frame);
    void take_response(Instant t, Slot& slot, const wire::Frame& frame);
    [[nodiscard]] bool unusual(Instant t, const Slot& slot, Bytes pdu) const;
    void confirm(Instant t, Slot& slot, Bytes pdu);
    [[nodiscard]] Instant quiet_at(Instant from, const Slot& slot, std::size_t pdu_length) const;
    [[nodiscard]] Instant confirmation_end(Instant t, const Slot& slot) const;
    [[nodiscard]] bool repeats(const wire::Frame& frame) const;
    void note_surplus(Instant t, UnitId unit, Bytes pdu);
    void keep_surplus(Instant t, UnitId unit, Bytes pdu);
    void conclude(Instant t, Slot& slot);
    [[nodiscard]] bool crossed(Instant t, const wire::Frame& frame) const;
    std::optional<Mismatch> note_foreign(const wire::Frame& frame);
    [[nodiscard]] std::size_t whole_length(const Slot& slot, Bytes begin) const;
    bool note_cut_short(Bytes begin);
    Lateness settle_late(Instant end, UnitId unit, const AnswerShape& shape, std::uint16_t wire_id);
    void settle_stray(Slot& slot);
    void note_late(Instant t, UnitId unit, Lateness lateness);
    void pass_over(bool late);
    void give_up(Instant t, Slot& slot, Status status);
    void link_down(Instant t, Status of_one_that_waits);
    [[nodiscard]] static Duration expected_time(const Slot& slot);
    [[nodiscard]] Instant patient_until(const Slot& slot, Instant hold_until) const;
    void expect_response(Instant t, const Slot& slot, Instant hold_until);
    void finish(Instant t, Slot& slot, Status status, const wire::ResponseView& response = {});
    Bytes send(Instant t, Slot& slot);
    [[nodiscard]] std::uint16_t next_wire_id();
    [[nodiscard]] static Outcome outcome_of(const Slot& slot);
    [[nodiscard]] Instant silence_end() const;
    [[nodiscard]] Instant busy_limit() const;
    [[nodiscard]] std::size_t occupied() const;
    [[nodiscard]] bool anything_sent() const;

    LineConfig config_;
    wire::TrafficObserver* observer_;
    wire::Framer framer_;
    EchoFilter echo_;
    OutstandingResponses outstanding_;
    InplaceVector<SurplusFrame, kMostSurplus> surplus_;
    LineCounters counters_;
    std::span<Slot> slots_;
    std::size_t longest_pdu_;
    BoundedVector<std::uint8_t> outgoing_;  // State::confirming: the PDU of the last response
    std::size_t following_ = 0;  // bytes behind the frame that is handled, received together with it
    std::uint64_t last_order_ = 0;
    TransactionIds ids_;
    bool link_up_ = false;
    bool must_reconnect_ = false;
    bool bad_header_ = false;
    // Why the owner must reconnect.
    HeaderFault header_fault_ = HeaderFault::unknown;
    InplaceVector<std::uint8_t, kMostRejected> rejected_;

    Duration silence_{};                       // least silence before a request
    Duration busy_limit_{};                    // the longest traffic without a silence
    Duration frame_silence_{};                 // silence that ends a received frame
    Instant last_activity_ = Instant::min();   // end of the last character on the line
    Instant activity_since_ = Instant::min();  // start of the traffic since the last silence
    Instant last_start_ = Instant::min();      // start of the last request
    Instant blocked_until_ = Instant::min();   // turnaround of a broadcast
    std::size_t bytes_since_gap_ = 0;          // bytes received since the last silence or frame
    std::size_t noise_ = 0;                    // bytes of no frame since the last request was sent
};

/// Memory for N transactions of any framing.
template <std::size_t N>
struct TransactionStorageOf {
    static constexpr std::size_t kOutstanding = 16;
    std::array<TransactionSlot, N> slots{};
    std::array<std::uint8_t, N * wire::kMaxPdu> pdus{};
    std::array<std::uint8_t, wire::kMaxAsciiFrame> sending{};
    std::array<std::uint8_t, wire::Framer::kMaxStorage> receiving{};
    std::array<OutstandingResponse, kOutstanding> outstanding{};
};

/// An engine with its own memory for N transactions.
template <std::size_t N>
class TransactionEngineOf final : TransactionStorageOf<N>, public TransactionCore {
    using Storage = TransactionStorageOf<N>;

public:
    explicit TransactionEngineOf(const LineConfig& config, wire::TrafficObserver* observer = nullptr)
        : TransactionCore(
              config,
              {Storage::slots, Storage::pdus, Storage::sending, Storage::receiving, Storage::outstanding},
              observer) {}
};

/// With as many transactions as LineConfig::in_flight can allow.
using TransactionEngine = TransactionEngineOf<kMaxInFlight>;

}  // namespace takt::bus
