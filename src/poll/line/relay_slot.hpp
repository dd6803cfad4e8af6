// The transaction of a client that shares a polled line.
#pragma once

#include <cstddef>
#include <optional>

#include "line/job_id.hpp"
#include "takt/base/result.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/bus/transaction_gate.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::poll {

/// One transaction of a client at a time: it waits, is in flight, and leaves an outcome that the client
/// takes. A gate decides which transactions go before polling, if any does.
///
/// It does not know the line: the caller submits the transaction and reports its end. One owner, one thread.
/// Never allocates.
class RelaySlot {
public:
    /// @param interval  of transactions that go before polling; nothing: none does
    explicit RelaySlot(std::optional<Duration> interval) {
        if (interval) gate_.emplace(1, *interval);
    }

    /// Neither a transaction nor an outcome is in it.
    [[nodiscard]] bool empty() const { return !transaction_ && !outcome_; }
    /// Requires empty().
    /// @param device  that the transaction is for, if the line has it
    /// @param spare   as of LinePoller::relay()
    /// @returns out_of_range for an empty request
    [[nodiscard]] Result<void> put(const bus::Transaction& transaction, std::optional<std::size_t> device,
                                   bool spare = false);
    /// The transaction is taken back if it waits.
    /// @returns false: it does not
    bool withdraw();
    /// The response in it is valid until the next put().
    [[nodiscard]] std::optional<bus::Outcome> take_outcome();

    /// A transaction waits.
    [[nodiscard]] bool waiting() const { return transaction_ && !in_flight_; }
    // of the transaction:
    [[nodiscard]] UnitId unit() const { return transaction_->unit; }
    [[nodiscard]] bus::AnswerShape shape() const { return bus::answer_shape(transaction_->request.shape()); }
    [[nodiscard]] std::optional<std::size_t> device() const { return device_; }
    [[nodiscard]] bool only_reads() const { return only_reads_; }
    [[nodiscard]] bool spare() const { return spare_; }
    [[nodiscard]] const bus::Transaction& transaction() const { return *transaction_; }
    /// Its position among what may be sent.
    [[nodiscard]] Candidate candidate(Instant t) const;

    /// It is chosen. @returns what to submit; then submitted() or give_up() must follow
    [[nodiscard]] bus::Transaction start(Instant t);
    void submitted(Instant t);
    /// The transaction that was submitted has ended.
    /// @param line_free  when the next one can start
    /// @returns false: it was given up before, and the outcome is dropped
    bool end(const bus::Outcome& outcome, Instant line_free);
    /// The transaction ends with this status, if there is one; one in flight too.
    void give_up(Instant t, bus::Status status, Instant line_free);

private:
    void finish(bus::Outcome outcome, Instant line_free);

    std::optional<bus::TransactionGate> gate_;     // of those that go before polling
    std::optional<bus::Transaction> transaction_;  // waits or is in flight
    std::optional<std::size_t> device_;
    bool only_reads_ = false;
    bool spare_ = false;
    bool in_flight_ = false;
    Instant last_start_ = Instant::min();
    std::optional<bus::Outcome> outcome_;  // not taken yet
    wire::Pdu response_;                   // the bytes of its response, which outlive the engine's buffer
};

}  // namespace takt::poll
