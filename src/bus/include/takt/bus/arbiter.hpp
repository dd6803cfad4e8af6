// Chooses the next transaction of a line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "takt/base/time.hpp"
#include "takt/bus/transaction_gate.hpp"

namespace takt::bus {

/// Classes of urgency, the most urgent first.
enum class Urgency : std::uint8_t {
    commanded,   ///< triggers, writes and commands
    relayed,     ///< requests of other masters
    overdue,     ///< polling and probes that have waited for several of their deadlines
    polled,      ///< polling
    background,  ///< period 0, probes, trial reads; events that the rate limit of the line does not admit
};

/// The key of an event without a deadline.
inline constexpr std::int64_t kNoDeadline = std::numeric_limits<std::int64_t>::max();

/// The order in which candidates go: the least first.
struct Priority {
    Urgency urgency = Urgency::background;
    std::int64_t key = 0;         ///< nanoseconds: a deadline, or an instant
    std::uint64_t tie_break = 0;  ///< position in the plan, or order of arrival
    friend constexpr auto operator<=>(const Priority&, const Priority&) = default;
};

/// A request that may be sent next.
struct Candidate {
    Urgency urgency = Urgency::background;
    std::int64_t key = 0;
    std::uint64_t tie_break = 0;
    std::uint64_t job = 0;    ///< the owner's number of what is sent
    bool by_trigger = false;  ///< a read for its trigger
    bool polling = false;     ///< polling or a probe
    bool late = false;        ///< of polling: it has waited longer than its deadline

    [[nodiscard]] constexpr Priority priority() const { return {urgency, key, tie_break}; }
};

/// The state of a polled read, as far as its order depends on it.
struct PolledRead {
    std::uint64_t job = 0;
    Duration period{};   ///< zero: as fast as the line allows
    Duration allowed{};  ///< its deadline; of a slowed one the distance of its probes
    Instant since;       ///< the start of its waiting time
    Instant last_start = Instant::min();
    bool slowed = false;     ///< it failed too often and is only probed
    std::uint64_t rank = 0;  ///< the order of equal deadlines
    std::size_t position = 0;
};

/// The order of transactions: shortest deadline first within classes of urgency (fixed priorities, as the
/// proof assumes: docs/guarantees.md), without preemption.
///
/// - Polling that has waited for overdue_factor() deadlines is promoted. Promoted reads take turns.
/// - With `rounds`, polled reads go by ascending position in rounds instead.
/// - Events without a rate limit of their own share that of the line. Those that it does not admit wait for a
///   moment without due polling: in the background every second transaction is one of them.
/// - However many events there are: of two transactions at least one is polling that is late.
///
/// For each transaction the owner calls begin(), offers candidates, and calls choose(). It may offer all of
/// them, or leave out reads that are surely not the first. An owner with many reads keeps them in heaps by
/// polled().priority() and changes_at(), and offers the top: the cost of a choice then grows with the
/// logarithm of their number. The result is the same.
///
/// Time is given by the caller and must not run backwards. One owner, one thread; copying copies the state.
/// Never allocates.
class Arbiter {
public:
    /// @param burst, interval  the rate limit of events that have none of their own (TransactionGate)
    /// @param rounds           polled reads go in rounds by ascending position
    Arbiter(std::uint32_t burst, Duration interval, bool rounds)
        : events_(burst, interval), rounds_(rounds) {}

    /// A plan, or a new one: its utilization (overdue_factor()) and the number of positions. The round begins
    /// anew.
    void set_plan(double utilization, std::size_t positions);

    // ---- candidates

    /// A polled read that is due.
    [[nodiscard]] Candidate polled(Instant t, const PolledRead& read) const;
    /// The first instant at which the priority of a due read differs from that of polled(t), in time alone;
    /// kNever: it does not change.
    [[nodiscard]] Instant changes_at(Instant t, const PolledRead& read) const;
    /// The probe of a device that does not answer. `since` is when it became due, `allowed` the distance of
    /// probes. Of `read` it has job, rank and last_start.
    [[nodiscard]] Candidate probe(Instant t, const PolledRead& read) const;
    /// A trigger, a write or a command in the order of arrival.
    [[nodiscard]] static Candidate event(std::uint64_t job, std::uint64_t order);
    /// The same with a rate limit of its own: before those without one, by its deadline.
    [[nodiscard]] static Candidate event(std::uint64_t job, Duration deadline, std::uint64_t rank);
    /// Moves an event without a rate limit of its own to the background if the line does not admit it now.
    void defer(Instant t, Candidate& event) const;

    // ---- a choice

    /// Forgets all candidates and wake-ups.
    void begin();
    /// @param start  the earliest instant at which it may be sent; after `t` it is only a wake-up
    void offer(Instant t, Instant start, const Candidate& candidate);
    /// The choice may change at that instant.
    void wake_at(Instant instant) { wakeup_ = instant < wakeup_ ? instant : wakeup_; }
    /// A periodic read is due. Without one, the next round begins with the first position.
    void keep_round() { in_round_ = true; }
    /// The first of the candidates since begin(); nothing: none may be sent now.
    [[nodiscard]] const std::optional<Candidate>& best() const { return best_; }
    /// The candidate to send: best(), or late polling whose turn it is.
    [[nodiscard]] std::optional<Candidate> choose();
    /// When to choose again if no event comes first; kNever: at no time.
    [[nodiscard]] Instant wakeup() const { return wakeup_; }

    // ---- transactions

    /// The candidate is sent.
    void started(const Candidate& candidate);
    /// A polled read at that position is sent.
    void advance_round(std::size_t position) { cursor_ = position + 1; }
    void restart_round() { cursor_ = 0; }
    /// A transaction of an event without a rate limit of its own is sent.
    /// @param admitted  an earlier one of the same event took the token of the line; becomes true
    void event_started(Instant t, bool& admitted);
    /// It has ended; the line is free at `free`, which may lie in the future.
    void event_ended(Instant free) { events_.ended(free); }

private:
    [[nodiscard]] Instant overdue_after(const PolledRead& read) const;

    TransactionGate events_;
    std::optional<Candidate> best_;
    std::optional<Candidate> late_;  // the first polling among the candidates that is late
    Instant wakeup_ = kNever;
    std::size_t cursor_ = 0;  // of the round: the next position
    std::size_t positions_ = 0;
    int overdue_factor_ = 1;
    bool rounds_;
    bool in_round_ = false;
    bool event_was_last_ = false;    // the last transaction took a token of the line
    bool polling_was_last_ = false;  // the last transaction was polling
};

}  // namespace takt::bus
