// The transaction engine of one line or connection: the only master there is (docs/architecture.md).
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <span>

#include "takt/base/bounded_vector.hpp"
#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
#include "takt/bus/counters.hpp"
#include "takt/bus/echo_filter.hpp"
#include "takt/bus/late_answers.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/wire/framer.hpp"
#include "takt/wire/traffic.hpp"

namespace takt::bus {

/// One transaction inside an engine: its place from submit() until its outcome is taken.
class TransactionSlot {
    friend class TransactionCore;
    enum class State : std::uint8_t { empty, waiting, sent, ended };

    State state = State::empty;
    Status status = Status::ok;
    UnitId unit;
    bool sent_once = false;
    bool broadcast = false;
    bool garbled = false;       // bytes came that did not check
    std::uint16_t wire_id = 0;  // transaction id of the MBAP header
    std::uint16_t pdu_size = 0;
    std::uint8_t* pdu = nullptr;  // the bytes of the request; once it has ended, of the response
    TransactionId id = 0;
    wire::RequestShape request;   // decoded once, by whoever made the transaction
    wire::ResponseView response;  // points to pdu
    Duration wait{};
    Duration late_limit{};
    Instant submitted_at;
    Instant sent_at;
    Instant request_end;
    Instant deadline;
    Instant ended_at;
    std::uint64_t order = 0;  // in which the outcomes became known

    [[nodiscard]] bool open() const { return state == State::waiting || state == State::sent; }
    [[nodiscard]] Bytes content() const { return {pdu, pdu_size}; }
    [[nodiscard]] AnswerShape shape() const { return answer_shape(request); }
    void fill(Bytes bytes) {
        std::copy(bytes.begin(), bytes.end(), pdu);
        pdu_size = static_cast<std::uint16_t>(bytes.size());
    }
};

/// What an engine works in, lent by its owner, who knows how much of it a line needs.
struct TransactionRoom {
    std::span<TransactionSlot> slots;  ///< 1..kMaxInFlight: transactions at a time
    /// For each slot longest_pdu bytes: its request, and then its response.
    std::span<std::uint8_t> pdus;
    std::span<std::uint8_t> sending;      ///< sending_room(): the frame that is being sent
    std::span<std::uint8_t> receiving;    ///< receiving_room(): the frame that is being received
    LateAnswers* late_answers = nullptr;  ///< not needed for Framing::tcp, whose frames are numbered
    /// Longest request and longest response there will be; less than wire::kMaxPdu for Framing::tcp only.
    std::size_t longest_pdu = wire::kMaxPdu;

    static constexpr std::size_t sending_room(wire::Framing framing,
                                              std::size_t longest_pdu = wire::kMaxPdu) {
        return wire::frame_length(framing, longest_pdu);
    }
    static constexpr std::size_t receiving_room(wire::Framing framing,
                                                std::size_t longest_pdu = wire::kMaxPdu) {
        return framing == wire::Framing::tcp ? wire::frame_length(framing, longest_pdu)
                                             : wire::Framer::room(framing);
    }
};

/// Sends requests one by one (Framing::tcp: up to `in_flight` at once), and gives every one exactly one
/// outcome.
///
/// Sending. Before a request the line was silent for max(t3.5, frame_gap) (RTU on a serial line; else
/// frame_gap), counted from the last character anyone sent; the start of the request before is request_gap
/// ago; no late answer can be taken for its own.
///
/// Waiting. One deadline, see Transaction::wait, whatever arrives meanwhile. A frame of another unit,
/// function or transaction id is counted and the waiting goes on. A frame of the right unit and function that
/// cannot be the answer (byte count, echo of a write) ends the transaction at once as unexpected_reply. Bytes
/// that do not check end it as bad_checksum: at the pause behind them (LineConfig::frame_silence) when they
/// were at least as many as the answer's, else at the deadline. After each of these, and after a time-out,
/// its late answer is reckoned with, unless the answer was seen garbled.
///
/// Serial broadcasts (unit 0) have no response: they are ok after the broadcast turnaround. Over Framing::tcp
/// unit 0 is the server itself.
///
/// A waiting request that the line's other stations leave no silence for is given up as line_busy after a
/// second.
///
/// The owner calls take_outcome() after each on_link, on_bytes, on_tick and cancel_all until there is none: a
/// transaction keeps its place until its outcome was taken. Never allocates; no I/O.
class TransactionCore : public Engine {
public:
    /// @param room      must outlive the engine; there are as many transactions at a time as it has slots, if
    ///                  LineConfig::in_flight is not less
    /// @param observer  told of every frame; may be nullptr; must outlive the engine
    TransactionCore(const LineConfig& config, const TransactionRoom& room,
                    wire::TrafficObserver* observer = nullptr);
    TransactionCore(const TransactionCore&) = delete;
    TransactionCore& operator=(const TransactionCore&) = delete;

    void on_link(Instant t, bool up) override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    [[nodiscard]] Bytes transmit(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override;

    /// Whether submit() has room, and the link is up.
    [[nodiscard]] bool can_submit() const;

    /// Takes a transaction; it is sent by transmit() as soon as it may.
    /// @returns queue_full (transactions at a time); connection_lost; out_of_range for an empty PDU;
    ///          unsupported (function) for a broadcast of what is no write; too_long (bytes, longest_pdu)
    [[nodiscard]] Result<void> submit(Instant t, const Transaction& transaction);

    /// When a request to `unit` with that answer could start at the earliest, if nothing more happens on the
    /// line. A poller that submits no earlier can still change its mind until then. Not before the past: may
    /// be below now.
    [[nodiscard]] Instant earliest_start(UnitId unit, const AnswerShape& shape) const;

    /// Gives up everything, sent or not. Late answers are reckoned with.
    void cancel_all(Instant t);

    /// The next outcome, in the order they became known.
    [[nodiscard]] std::optional<Outcome> take_outcome();

    /// Nothing is waiting, in flight, or left to be taken.
    [[nodiscard]] bool idle() const;

    [[nodiscard]] bool link_up() const { return link_up_; }
    /// The byte stream is out of step (a wrong MBAP header): the connection must be closed and made anew.
    [[nodiscard]] bool must_reconnect() const { return must_reconnect_; }
    [[nodiscard]] const LineCounters& counters() const { return counters_; }
    [[nodiscard]] const LineConfig& config() const { return config_; }
    /// The least silence before a request.
    [[nodiscard]] Duration silence() const { return silence_; }

private:
    using Slot = TransactionSlot;
    using State = TransactionSlot::State;

    void notice_silence(Instant t);
    void notice_deadlines(Instant t);
    void note_activity(Instant t, std::size_t bytes);
    void read(Instant t, Bytes bytes);
    void handle(Instant t, const wire::FramerStep& step);
    void on_frame(Instant t, const wire::Frame& frame);
    void on_fault(Instant t, wire::FrameFault fault);
    Slot* addressee(const wire::Frame& frame);
    void take_response(Instant t, Slot& slot, Bytes pdu);
    void pass_over(bool late);
    void give_up(Instant t, Slot& slot, Status status);
    void finish(Instant t, Slot& slot, Status status, const wire::ResponseView& response = {});
    Bytes send(Instant t, Slot& slot);
    [[nodiscard]] static Outcome outcome_of(const Slot& slot);
    [[nodiscard]] Instant silence_end() const;
    [[nodiscard]] Instant busy_limit() const;
    [[nodiscard]] std::size_t occupied() const;
    [[nodiscard]] bool anything_sent() const;
    [[nodiscard]] Duration response_time(const Slot& slot) const;
    [[nodiscard]] Duration length_of(std::size_t characters) const;

    LineConfig config_;
    wire::TrafficObserver* observer_;
    wire::Framer framer_;
    EchoFilter echo_;
    LateAnswers* late_;
    LineCounters counters_;
    std::span<Slot> slots_;
    std::size_t longest_pdu_;
    BoundedVector<std::uint8_t> outgoing_;
    std::uint64_t last_order_ = 0;
    std::uint16_t next_wire_id_ = 0;
    bool link_up_ = false;
    bool must_reconnect_ = false;
    Duration silence_{};                       // least silence before a request
    Duration frame_silence_{};                 // silence that ends a received frame
    Instant last_activity_ = Instant::min();   // end of the last character on the line
    Instant activity_since_ = Instant::min();  // start of the activity without a silence
    Instant last_start_ = Instant::min();      // start of the last request
    Instant blocked_until_ = Instant::min();   // turnaround of a broadcast
    std::size_t lump_ = 0;                     // bytes since the last silence or frame
};

/// Room for N transactions of any framing.
template <std::size_t N>
struct TransactionRoomOf {
    std::array<TransactionSlot, N> slots{};
    std::array<std::uint8_t, N * wire::kMaxPdu> pdus{};
    std::array<std::uint8_t, wire::kMaxAsciiFrame> sending{};
    std::array<std::uint8_t, wire::Framer::kMostRoom> receiving{};
    LateAnswers late_answers;
};

/// An engine with its own room for N transactions.
template <std::size_t N>
class TransactionEngineOf final : TransactionRoomOf<N>, public TransactionCore {
    using Room = TransactionRoomOf<N>;

public:
    explicit TransactionEngineOf(const LineConfig& config, wire::TrafficObserver* observer = nullptr)
        : TransactionCore(config,
                          {Room::slots, Room::pdus, Room::sending, Room::receiving, &(Room::late_answers)},
                          observer) {}
};

/// For whatever LineConfig::in_flight allows.
using TransactionEngine = TransactionEngineOf<kMaxInFlight>;

}  // namespace takt::bus
