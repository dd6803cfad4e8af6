// The polling engine of one line: runs its plan (specification, section 7).
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
#include "takt/poll/lesson.hpp"
#include "takt/poll/project_slots.hpp"
#include "takt/poll/statistics.hpp"
#include "takt/value/command.hpp"
#include "takt/value/store.hpp"
#include "takt/wire/traffic.hpp"

namespace takt::poll {

/// Settings of the bus for a line of a project: framing, character format, gaps, margin. Echoes are looked
/// for on serial ports only; over TCP there is one transaction at a time.
bus::LineConfig line_config(const model::Project& project, const model::Line& line);

/// Runs one LinePlan on one bus::TransactionEngine, with the values in a value::Store.
///
/// All requests of the line share one grid of instants that begins when the link comes up: a request is due
/// at its phase and then each period. A device that comes back is read once at once, then on the grid again.
/// Releases that pass while one is waiting are skipped and counted.
///
/// One queue. First what was commanded or triggered: what has an admission (guarantees, "Write on command")
/// by its deadline, then the rest in the order it came. Then polling: by Request::deadline (ties by unit,
/// function, start), or in rounds by ascending address; last what has period 0, and probes. By deadline,
/// polling that has waited far beyond its own (four deadlines; one where the plan itself cannot hold its
/// periods) goes before the rest, in the order in which it was last served: a line that is too slow slows
/// everybody down instead of starving some.
///
/// What an admission holds back waits, together with what comes meanwhile; a failed attempt is repeated
/// without a new one. Bits of a register are written by 0x16, or read and written back without anything
/// between: those that were set, no others. A value longer than a request is shown when all its parts were
/// read in one round.
///
/// A failed read goes back into the queue with its priority; after `attempts` failures in a row of a device
/// it counts as not answering, and is probed with one read each back-off. A single
/// request that fails as often while its device answers others is slowed down in the same way. Exceptions are
/// answers: no retry before the next period, and with codes 5 and 6 not before a back-off of 100 ms doubling
/// to 10 s; codes 10 and 11 (gateway) count as failures.
///
/// A write of variables with `verify` is read back when the device confirmed it, with the place in the queue
/// that the write had; until then nothing else is written to that device. It is done when the values are
/// equal; refused (Reason::differs) when not, or sent again where it is safe_to_repeat; unknown when the
/// reading back fails `attempts` times, or cannot be.
///
/// Writes are never repeated when their outcome is unknown, unless every variable written is safe_to_repeat.
/// What is commanded or triggered while its device is switched off or does not answer is refused or dropped
/// at once; what was set() waits for the device. A value that was refused or expired is no longer wanted. A
/// group is written with the last value of each member: a command that waits with an earlier one is refused
/// as superseded. What was refused after an attempt that left it open is unknown.
///
/// With gaps: learn unconfirmed gaps are tried by single reads when nothing is due for as long as they take,
/// or after two seconds without such a moment, and only confirmed ones are polled: a refusal costs no value
/// its freshness. A polled read that bridges gaps and is refused is repeated like a failed one; three times
/// in a row, and its gaps are unconfirmed again.
///
/// One owner, one thread; the project, the plan, the slots and the store must outlive it.
class LinePoller final : public Engine {
public:
    struct Options {
        std::optional<bus::LineConfig> bus;        ///< instead of line_config()
        wire::TrafficObserver* traffic = nullptr;  ///< may be nullptr; must outlive the poller
        PollObserver* observer = nullptr;          ///< likewise
        /// Devices with gaps: learn are tried, and the plan follows what they show; the one given at first is
        /// not used then. Else exactly that plan is run.
        bool learn = true;
        PlanMaker* plan_maker = nullptr;  ///< nullptr: plans are made at once; must outlive the poller
    };
    static constexpr std::size_t kMaxCommands = 256;

    LinePoller(const model::Project& project, const plan::LinePlan& plan, const ProjectSlots& slots,
               value::Store& store, const Options& options);
    LinePoller(const model::Project& project, const plan::LinePlan& plan, const ProjectSlots& slots,
               value::Store& store);
    ~LinePoller();
    LinePoller(const LinePoller&) = delete;
    LinePoller& operator=(const LinePoller&) = delete;

    void on_link(Instant t, bool up) override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    [[nodiscard]] Bytes transmit(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override;
    /// bus::TransactionEngine::must_reconnect(); also a connection on which no device answers and nothing at
    /// all was heard for 30 s, then doubling to 10 min until something is heard. To be asked after every
    /// call.
    [[nodiscard]] bool must_reconnect() const;

    /// What a variable of this line is to be. Where it is written on change its group is written; with a
    /// start-writing trigger the trigger will write it.
    /// @returns not_writable (subject: name); overflow, out_of_range, unsupported when the value does not fit
    [[nodiscard]] Result<bool> set(Instant t, value::SlotId slot, const value::Value& value);

    /// Writes a variable of this line now: with its group where it is written on change, else alone. An error
    /// is the command's outcome; else take_outcome() will have one.
    /// @returns queue_full (kMaxCommands), and what set() returns. The value tells whether it had to be
    /// rounded.
    [[nodiscard]] Result<bool> write(Instant t, const value::WriteCommand& command);

    [[nodiscard]] std::optional<value::CommandOutcome> take_outcome();

    /// Takes a transaction of somebody else, who shares the line (model::Line::relayed), one at a time. It is
    /// sent when nothing else is due, or ahead of polling (not of what was commanded or triggered) when none
    /// was for Line::relay_interval; so each relayed transaction that is waited for is one of the plan's
    /// proof (docs/guarantees.md). It is sent once. To a device of the line it is waited for as long as the
    /// line's own requests are; while a write to that device is read back, only reads are sent to it.
    /// @returns unsupported (the line is not shared; a broadcast of what is no write); queue_full (1: it has
    ///          one, or its outcome was not taken); connection_lost; out_of_range for an empty PDU
    [[nodiscard]] Result<void> relay(Instant t, const bus::Transaction& transaction);

    [[nodiscard]] bool link_up() const;

    /// Whether relay() would take one.
    [[nodiscard]] bool can_relay() const;

    /// What became of it, as the engine tells; link_lost also where it was not sent yet. Its response is valid
    /// until the next relay().
    [[nodiscard]] std::optional<bus::Outcome> take_relayed();

    /// A local changed in the store: triggers and enables are looked at. Call it on every line.
    void on_local(Instant t, model::LocalIndex local, const value::Value& before, const value::Value& after);

    /// The plan a PlanMaker was asked for. It is run from the next moment on at which no transaction is under
    /// way: values, statistics of variables and whatever waits are kept, and nothing is read later than it
    /// would have been.
    void replace_plan(plan::LearningPlan plan);

    /// Whether a device of the line is tried.
    [[nodiscard]] bool learns() const;
    /// What is known of each device of the line; what the project says where it does not learn.
    [[nodiscard]] std::vector<model::Learnt> learnt(Instant t) const;

    [[nodiscard]] LineStatistics statistics(Instant t) const;
    [[nodiscard]] const DeviceStatistics& device(std::size_t device) const;
    /// By the index of the request in the plan.
    [[nodiscard]] RequestStatistics request(std::size_t request) const;
    /// By its indices in the line.
    [[nodiscard]] VariableStatistics variable(std::size_t device, std::size_t variable) const;
    /// The plan that runs. Changes when it is replaced, in transmit().
    [[nodiscard]] const plan::LinePlan& plan() const;

private:
    class Run;
    std::unique_ptr<Run> run_;
};

}  // namespace takt::poll
