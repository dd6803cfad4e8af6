// The inside of LinePoller: its tables, and the four parts that work on them (run.cpp, schedule.cpp,
// outcomes.cpp, writes.cpp).
#pragma once

#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "takt/bus/health.hpp"
#include "takt/bus/release.hpp"
#include "takt/bus/transaction_engine.hpp"
#include "takt/poll/line_poller.hpp"
#include "transfer.hpp"

namespace takt::poll {

using bus::Backoff;
using bus::busy_backoff;
using bus::Health;
using bus::PeriodicRelease;
using bus::PeriodMeter;

/// The read half of a request of the plan.
struct ReadJob {
    wire::ReadRequest request;
    wire::Pdu pdu;
    bus::AnswerShape shape;
    Duration deadline{};  // relative to the release
    bool polled = false;  // by period
    PeriodicRelease release{Duration::zero()};
    PeriodMeter meter{Duration::zero()};
    Health health{1};
    Backoff busy = busy_backoff();
    Instant not_before = Instant::min();  // the device asked for patience
    std::optional<Instant> retry;         // a failed polled read is back in the queue since then
    bool triggered = false;
    std::uint64_t order = 0;  // among what was triggered and commanded
    bool by_trigger = false;  // of the transaction under way
    Instant last_start = Instant::min();
    bus::TimeStatistics time;
};

/// The write half.
struct WriteJob {
    wire::Function function = wire::Function::write_multiple_registers;
    bus::AnswerShape shape;
    bool asked = false;        // by set(), or again after a failure
    bool triggered = false;    // by its trigger
    std::size_t commands = 0;  // by so many commands that are not under way
    std::uint64_t order = 0;
    std::uint16_t failures = 0;
    Backoff busy = busy_backoff();
    Instant not_before = Instant::min();
    bool told_waiting = false;

    [[nodiscard]] bool due() const { return asked || triggered || commands > 0; }
};

struct RequestRun {
    const plan::Request* plan = nullptr;
    std::size_t device = 0;
    std::vector<std::size_t> variables;  // indices into Run::variables_
    std::optional<ReadJob> read;
    std::optional<WriteJob> write;
    value::Reason last_reason = value::Reason::ok;
    RequestStatistics statistics;
};

struct DeviceRun {
    const model::Device* model = nullptr;
    std::vector<std::size_t> requests;
    Duration wait{};
    Health health{1};
    bool enabled = true;
    bool in_flight = false;
    bool has_reads = false;
    DeviceStatistics statistics;
};

/// Whether anything but a probe may be asked of it: it is switched on, and answers. Without reads there are
/// no probes; then what is to be written takes their place.
inline bool reachable(const DeviceRun& device) {
    return device.enabled && (device.health.answering() || !device.has_reads);
}

struct VariableRun {
    const model::Variable* model = nullptr;
    value::SlotId slot;
    std::size_t device = 0;
    std::optional<std::size_t> change_group;   // the request that writes it on change
    std::optional<std::size_t> trigger_group;  // the request that writes it by a trigger
    value::Value last_read;
};

/// A command that waits or is under way: written with the group `group`, or alone.
struct PendingCommand {
    value::WriteCommand command;
    std::size_t variable = 0;
    bool rounded = false;
    std::uint64_t order = 0;
    std::optional<std::size_t> group;
    value::Value wanted_before;  // with a group: to be restored where nothing was sent
    // alone:
    wire::Pdu pdu;
    bus::AnswerShape shape;
    std::uint16_t failures = 0;
    Backoff busy = busy_backoff();
    Instant not_before = Instant::min();
    bool in_flight = false;
    bool sent = false;  // at least once
};

/// What stands at the front of the queue, and how the candidates compare: by class, then by time, then by
/// place.
enum class Urgency : std::uint8_t { commanded, overdue, polled, background };
enum class JobKind : std::uint8_t { read, group_write, command };
struct Candidate {
    Urgency urgency = Urgency::background;
    std::int64_t key = 0;
    std::size_t place = 0;
    JobKind kind = JobKind::read;
    std::size_t index = 0;  // request, or for a command its order
    bool by_trigger = false;

    [[nodiscard]] bool before(const Candidate& other) const {
        if (urgency != other.urgency) return urgency < other.urgency;
        return key != other.key ? key < other.key : place < other.place;
    }
};

/// How an outcome is treated: what the user is told, and whether it was an answer of the device.
struct Verdict {
    value::Reason reason = value::Reason::ok;
    bool answered = false;  // the device itself said something
    bool busy = false;      // exceptions 5 and 6
};
Verdict verdict_of(const bus::Outcome& outcome);

class LinePoller::Run {
public:
    Run(const model::Project& project, const plan::LinePlan& plan, const ProjectSlots& slots,
        value::Store& store, const Options& options);

    void on_link(Instant t, bool up);
    void on_bytes(Instant t, Bytes bytes);
    void on_tick(Instant t);
    Bytes transmit(Instant t);
    [[nodiscard]] Instant next_wakeup() const;

    Result<bool> set(Instant t, value::SlotId slot, const value::Value& value);
    Result<bool> write(Instant t, const value::WriteCommand& command);
    void on_local(Instant t, model::LocalIndex local, const value::Value& before, const value::Value& after);

    const model::Project& project_;
    const model::Line& line_;
    const plan::LinePlan& plan_;
    const ProjectSlots& slots_;
    value::Store& store_;
    PollObserver* observer_;
    bus::TransactionEngine engine_;

    std::vector<VariableRun>
        variables_;  // in the order of the project: slots first_slot_, first_slot_ + 1, ...
    std::uint32_t first_slot_ = 0;
    std::vector<DeviceRun> devices_;
    std::vector<RequestRun> requests_;
    std::vector<PendingCommand> commands_;
    std::deque<value::CommandOutcome> outcomes_;
    std::optional<Instant> up_since_;
    Duration busy_time_{};

private:
    // run.cpp
    void add_variables();
    void add_requests();
    void add_groups(std::size_t request);
    void restart_device(Instant t, DeviceRun& device);
    void set_device_state(Instant t, std::size_t device, DeviceState state);
    void switch_device(Instant t, std::size_t device, bool on);
    void take_outcomes();

    // schedule.cpp
    void choose(Instant t);
    void consider(Instant t, UnitId unit, const bus::AnswerShape& shape, Instant due,
                  const Candidate& candidate, std::optional<Candidate>& best);
    void consider_read(Instant t, std::size_t request, std::optional<Candidate>& best);
    void consider_write(Instant t, std::size_t request, std::optional<Candidate>& best);
    void consider_probe(Instant t, std::size_t device, std::optional<Candidate>& best);
    [[nodiscard]] Candidate polling_rank(Instant t, std::size_t request) const;
    void start(Instant t, const Candidate& candidate);
    void start_read(Instant t, std::size_t request, bool by_trigger);
    void start_group(Instant t, std::size_t request);
    void submit(Instant t, std::size_t device, bus::TransactionId id, const wire::Pdu& pdu);
    void wake_at(Instant t);

    void on_outcome(const bus::Outcome& outcome);

    // outcomes.cpp
    Verdict judge(const bus::Outcome& outcome, std::size_t device, bus::TransactionCounters* counters);
    void on_read(const bus::Outcome& outcome, std::size_t request);
    void take_values(Instant t, RequestRun& request, Bytes pdu);
    void fail_read(Instant t, RequestRun& request, value::Reason reason);
    void degrade(Instant t, std::span<const std::size_t> variables, value::Quality quality,
                 value::Reason reason, bool to_default);
    void degrade_device(Instant t, std::size_t device, value::Reason reason, bool to_default);
    void set_status(Instant t, RequestRun& request, value::Reason reason);
    void set_device_status(Instant t, std::size_t device);
    void put_status(Instant t, model::LocalIndex local, value::Reason reason);

    // writes.cpp
    struct WriteVerdict {
        value::CommandResult result = value::CommandResult::done;
        bool again = false;  // it may be sent once more instead
    };
    static WriteVerdict judge_write(const bus::Outcome& outcome, const Verdict& verdict, bool safe_to_repeat);
    bool may_repeat(const DeviceRun& device, const Verdict& verdict, std::uint16_t& failures) const;
    void on_group_written(const bus::Outcome& outcome, std::size_t request);
    void on_command_written(const bus::Outcome& outcome, std::uint64_t order);
    void finish_group(Instant t, std::size_t request, value::CommandResult result, value::Reason reason);
    void show_written(Instant t, std::size_t variable, const value::Value& value);
    [[nodiscard]] Result<std::size_t> writable(value::SlotId slot) const;
    [[nodiscard]] const value::Value* value_to_write(std::size_t variable) const;
    [[nodiscard]] bool repeatable(std::span<const std::size_t> variables) const;
    void ask_group(std::size_t request);
    bool group_ready(Instant t, std::size_t request);
    Result<wire::Pdu> group_pdu(const RequestRun& request);
    void withdraw(Instant t, const PendingCommand& command, value::CommandResult unsent,
                  value::Reason reason);
    void finish(Instant t, const PendingCommand& command, value::CommandResult result, value::Reason reason);
    void drop_pending(Instant t, std::size_t device, value::Reason reason);
    void expire_commands(Instant t);

    std::size_t cursor_ = 0;  // order: address: the place in the round
    std::uint64_t last_order_ = 0;
    Instant wakeup_ = kNever;  // of the schedule alone, as of the last transmit()
    bool polling_due_ = false;
    std::vector<value::Update> updates_;  // scratch, so that a transaction allocates nothing
    std::vector<Member> members_;         // likewise
};

}  // namespace takt::poll
