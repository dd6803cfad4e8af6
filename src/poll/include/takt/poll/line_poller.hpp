// The polling engine of one line: runs its plan (docs/specification.md, section 7).
#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/learning.hpp"
#include "takt/plan/plan.hpp"
#include "takt/poll/gap_event.hpp"
#include "takt/poll/statistics.hpp"
#include "takt/value/command.hpp"
#include "takt/value/project_slots.hpp"
#include "takt/value/store.hpp"
#include "takt/wire/traffic.hpp"

namespace takt::poll {

/// The settings of the bus for a line of a project: framing, character format, gaps, margin. Echoes are
/// detected on serial ports only.
bus::LineConfig line_config(const model::Project& project, const model::Line& line);

/// Runs one LinePlan on one bus::TransactionEngine, with the values in a value::Store.
///
/// Release. All requests of the line share one grid of instants, whose origin is the moment the link first
/// came up. A connection that is closed or lost does not move it. A request is due at its phase and then once
/// each period. A device that answers again is read at once, and then on the grid. Releases that pass while
/// one is waiting are skipped and counted.
///
/// Order of the queue:
/// 1. Commands and triggers. Those with an admission (docs/planning.md, "Writes": rate limits) go by their
///    deadline, the others after them in the order of arrival. Commands of write() without an admission of
///    their own share that of the line (model::Line::commands, counted from the end of the last one).
/// 2. Polling, earliest Request::deadline first (ties by unit, function, start), or in rounds by ascending
///    address.
/// 3. Requests with period 0, probes, and commands that the line does not admit now. They take turns.
///
/// Overdue requests. By deadline, a polled request that has waited for several of its deadlines
/// (bus::overdue_factor) is promoted before other polling. Promoted requests go in the order in which they
/// were last served. So a line that is too slow delays all requests instead of starving some. While a
/// polled request waits longer than its deadline, commands, triggers and relayed requests alternate with
/// polling.
///
/// Admission. A request that its token bucket holds back waits, and is merged with those that arrive
/// meanwhile. A failed attempt is repeated without a new admission.
///
/// Connections. Over TCP a connection that the peer closes is no failure of the line. The request that alone
/// waited for a response has failed (Status::closed). It is repeated at once, unless its last attempt met a
/// close too. Of several, none has failed; they are sent again one at a time (CloseWatch). The next request
/// that is due opens the next connection. model::ConnectionRules says when the line closes it itself.
///
/// Values. A value longer than one request is published when all its parts were read in one round. A good
/// value that is older than its proved age (plan::LinePlan::ages), else than its `max_age`, becomes
/// uncertain, reason stale, also when nothing is read any more. Its age counts from the start of the read.
///
/// Failures. A failed read goes back into the queue with its priority. After `attempts` failures in a row the
/// device counts as not answering: it is probed with one read after each back-off. A request that fails as
/// often while its device answers other requests is slowed down in the same way. An exception is an answer:
/// there is no retry before the next period; after codes 5 and 6 there is a back-off of 100 ms, doubling to
/// 10 s. The gateway codes 10 and 11 count as failures.
///
/// Writes. Bits of a register are written with 0x16, or by a read and a write with nothing between them; only
/// the bits that were set change. A group is written with the latest value of each member: a waiting command
/// with an earlier value is refused as superseded. A write whose outcome is unknown is repeated only if all
/// its variables are safe_to_repeat. A command or trigger for a device that is switched off or does not
/// answer is refused or dropped at once; a value of set() waits for the device. A value that was refused or
/// has expired is no longer wanted. If an earlier attempt may have executed, a refusal is reported as
/// unknown.
///
/// Verification. A write of variables with `verify` is read back when the device has confirmed it, at the
/// position in the queue that the write had. Until then the device gets no other write. Equal values: done.
/// Different values: refused (Reason::differs), or sent again if safe_to_repeat. If the read fails `attempts`
/// times or cannot be sent: unknown.
///
/// Learning. With gaps: learn unconfirmed gaps are tested with reads of their own. Such a read is sent when
/// no other request is due for as long as it takes, or after two seconds without such a moment. Only
/// confirmed gaps are polled, so a refusal delays no value. If a polled read across gaps is refused, it is
/// repeated like a failed read; after three refusals in a row its gaps are unconfirmed again.
///
/// One owner, one thread; the project, the plan, the slots and the store must outlive it.
class LinePoller final : public Engine {
public:
    struct Options {
        std::optional<bus::LineConfig> bus;        ///< instead of line_config()
        wire::TrafficObserver* traffic = nullptr;  ///< may be nullptr; must outlive the poller
        PollObserver* observer = nullptr;          ///< likewise
        /// Whether gaps are learnt on devices with gaps: learn. The given plan is then replaced by one that
        /// follows the results. Otherwise exactly the given plan runs.
        bool learn = true;
        /// Whether other reads are sent instead of planned ones while a late response could be mistaken for
        /// theirs (docs/decisions/0032-in-step.md). Otherwise only planned ones, as by table::Executor.
        bool distinct_reads = true;
        PlanMaker* plan_maker = nullptr;  ///< nullptr: plans are made at once; must outlive the poller
    };
    static constexpr std::size_t kMaxCommands = 256;

    LinePoller(const model::Project& project, const plan::LinePlan& plan, const value::ProjectSlots& slots,
               value::Store& store, const Options& options);
    LinePoller(const model::Project& project, const plan::LinePlan& plan, const value::ProjectSlots& slots,
               value::Store& store);
    ~LinePoller();
    LinePoller(const LinePoller&) = delete;
    LinePoller& operator=(const LinePoller&) = delete;

    void on_link(Instant t, bool up) override;
    void on_close(Instant t) override;
    [[nodiscard]] std::optional<Instant> opens_at() const override;
    [[nodiscard]] std::optional<Error> rejection() const override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    [[nodiscard]] Bytes transmit(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override;
    /// bus::TransactionEngine::must_reconnect(). Also when no device answers and no byte was received on the
    /// connection for 30 s; this time doubles up to 10 min until a byte is received. Check it after every
    /// call.
    [[nodiscard]] bool must_reconnect() const;

    /// Sets the wanted value of a variable of this line. A variable with write_on_change is written with its
    /// group; one with a write trigger is written when the trigger fires.
    /// @returns not_writable (subject: name); overflow, out_of_range, unsupported when the value does not fit
    [[nodiscard]] Result<bool> set(Instant t, value::SlotId slot, const value::Value& value);

    /// Writes a variable of this line now: with its group if it is written on change, else alone. An error is
    /// the outcome of the command; otherwise take_outcome() returns one later.
    /// @returns whether the value was rounded; queue_full (kMaxCommands), and the errors of set()
    [[nodiscard]] Result<bool> write(Instant t, const value::WriteCommand& command);

    [[nodiscard]] std::optional<value::CommandOutcome> take_outcome();

    /// Ends the back-off of a device that does not answer: it is probed when the line is free.
    /// @returns false, and does nothing: the link is down, the device answers, is switched off or not read
    bool probe_now(Instant t, std::size_t device);

    /// From now on relay() accepts transactions on a line that is not shared too. They are sent when no other
    /// request is due, and never ahead of polling. The guarantees do not include them: one that is in flight
    /// delays what becomes due. Allocates once.
    void admit_guests();

    /// Accepts a transaction of a client that shares the line (model::Line::relayed), one at a time. It is
    /// sent when no other request is due. If the last one ended Line::relay_interval ago, it is sent before
    /// polling, but after commands and triggers: this bounds its share of the line (docs/guarantees.md). It
    /// is sent once. If polling knows that its device does not answer, it is not sent: its outcome is a
    /// timeout at once. For a device of the line, the time-outs of that device apply; while a write to it is
    /// read back, only reads are sent to it.
    /// @param spare  it is sent only if it has ended, answered or not, before another request is due. It
    ///               makes no polled request late, and on a busy line it may wait forever. On a shared line
    ///               it is one of the relayed ones instead, with their time-out
    /// @returns unsupported (the line is not shared); queue_full (1: it has one, or the outcome of the last
    ///          one was not taken); connection_lost; out_of_range for an empty request
    [[nodiscard]] Result<void> relay(Instant t, const bus::Transaction& transaction, bool spare = false);

    /// There is a link, or there will be one with the next request: the peer has closed the last one.
    [[nodiscard]] bool link_up() const;
    /// Whether there was a link at some time.
    [[nodiscard]] bool was_up() const;

    /// Whether relay() would accept a transaction.
    [[nodiscard]] bool can_relay() const;

    /// Whether a relayed transaction with that response need not wait because its response could be mistaken.
    /// One that waits keeps others from being sent: withdraw it.
    [[nodiscard]] bool may_start_relayed(Instant t, UnitId unit, const bus::AnswerShape& shape) const;

    /// The outcome of the relayed transaction; link_lost and timeout also if it was not sent. Its response is
    /// valid until the next relay().
    [[nodiscard]] std::optional<bus::Outcome> take_relayed();

    /// Takes the relayed transaction back if it was not sent yet. It then has no outcome.
    /// @returns false: it was sent, or there is none
    [[nodiscard]] bool withdraw_relayed();

    /// A local has changed in the store: evaluates triggers and enables. Call it on every line.
    void on_local(Instant t, model::LocalIndex local, const value::Value& before, const value::Value& after);

    /// Replaces the plan by the one requested from a PlanMaker, as soon as no transaction is in flight.
    /// Values, statistics of variables and waiting writes are kept. No variable is read later than by the old
    /// plan.
    void replace_plan(plan::LearningPlan plan);

    /// Stops polling: from now on only what was commanded, triggered or is being verified is sent. A relayed
    /// transaction that was not sent waits until it is withdrawn. For a poller that another one is to take
    /// over.
    void hold();
    /// Of one that is held: nothing is in flight, and nothing that was commanded waits.
    [[nodiscard]] bool quiet() const;
    /// Of one that is held: nothing is in flight.
    [[nodiscard]] bool idle() const;

    /// The run ends: every write that waits or is in flight gets its outcome now, expired if it was never
    /// sent, else unknown.
    void end_writes(Instant t);

    /// Continues where `old`, which is held and idle, is: link, late answers, counters; of the devices and
    /// variables that have the same name and settings also health, phases, statistics and what is to be
    /// written. Requests that wait in `old` expire, or end as unknown if they may have been sent. The values
    /// of this poller's slots were carried over before. `old` is not used afterwards but for take_outcome().
    /// Both lines have the same connection and framing.
    void take_over(Instant t, LinePoller& old);

    /// Whether a device of the line learns.
    [[nodiscard]] bool learns() const;
    /// The known gaps of each device; the values of the project for devices that do not learn.
    [[nodiscard]] std::vector<model::Learnt> learnt(Instant t) const;
    /// The same into memory of the caller, one element for each device, without allocating.
    /// @returns false where a list has less capacity than it needs; `into` is then incomplete
    [[nodiscard]] bool copy_learnt(Instant t, std::span<model::Learnt> into) const;

    /// The response times of a device, over all runs.
    [[nodiscard]] model::MeasuredTimes measured(std::size_t device) const;
    /// Of each device, to be kept for the next run.
    [[nodiscard]] std::vector<model::LearntTimes> learnt_times() const;
    /// Two responses had a header whose length was off by one, and the line does not accept them.
    [[nodiscard]] bool lengths_are_off() const;

    [[nodiscard]] LineStatistics statistics(Instant t) const;
    [[nodiscard]] DeviceStatistics device(std::size_t device) const;
    /// By the index of the request in the plan.
    [[nodiscard]] RequestStatistics request(std::size_t request) const;
    /// The response times of a request, from its start to the end of the response.
    [[nodiscard]] HistogramSnapshot request_times(std::size_t request) const;
    [[nodiscard]] LineTimes line_times() const;
    /// By its indices in the line.
    [[nodiscard]] VariableStatistics variable(std::size_t device, std::size_t variable) const;
    /// The plan that runs. Changes when it is replaced, in transmit().
    [[nodiscard]] const plan::LinePlan& plan() const;
    /// Grows each time another plan takes the place of the one that runs.
    [[nodiscard]] std::uint64_t plan_revision() const;

private:
    class Run;
    std::unique_ptr<Run> run_;
};

}  // namespace takt::poll
