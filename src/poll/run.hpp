// The inside of LinePoller: its tables, and the parts that work on them (run.cpp, restart.cpp, schedule.cpp,
// ready.cpp, outcomes.cpp, writes.cpp, commands.cpp, modify.cpp, verify.cpp, relayed.cpp, trials.cpp,
// replan.cpp).
#pragma once

#include <limits>
#include <list>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "boxed.hpp"
#include "learning.hpp"
#include "read_back.hpp"
#include "read_queue.hpp"
#include "split.hpp"
#include "takt/bus/health.hpp"
#include "takt/bus/release.hpp"
#include "takt/bus/token_bucket.hpp"
#include "takt/bus/transaction_engine.hpp"
#include "takt/poll/line_poller.hpp"
#include "transfer.hpp"

namespace takt::poll {

using bus::Backoff;
using bus::busy_backoff;
using bus::Health;
using bus::PeriodicRelease;
using bus::PeriodMeter;

/// What waits in the queue because something happened: at most as often as its bucket allows. What comes
/// while it waits is done together with it.
struct Admittance {
    std::optional<bus::TokenBucket> bucket;
    std::optional<Duration> deadline;  // of what the bucket lets through
    bool admitted = false;
    std::uint64_t order = 0;  // among what was triggered and commanded

    Admittance() = default;
    explicit Admittance(const std::optional<model::Admission>& admission);

    /// Something happened while nothing waited.
    void arrive(Instant t, std::uint64_t next_order) {
        order = next_order;
        admitted = !bucket || bucket->admit(t);
    }
    /// Whether it is in the queue, or comes into it now.
    bool admit(Instant t) {
        if (!admitted) admitted = !bucket || bucket->admit(t);
        return admitted;
    }
};

/// How a trigger asks for a read.
struct Triggering {
    std::int64_t round = 0;  // which change of the trigger that was
    Admittance admittance;
};

/// The read half of a request of the plan.
struct ReadJob {
    wire::ReadRequest request;
    bus::AnswerShape shape;
    std::size_t rank = 0;  // among all jobs of the line, in the order of the plan
    Duration deadline{};   // relative to the release
    bool polled = false;   // by period
    PeriodicRelease release{Duration::zero()};
    PeriodMeter meter{Duration::zero()};
    Health health{1};
    Backoff busy = busy_backoff();
    Instant not_before = Instant::min();  // the device asked for patience
    std::optional<Instant> retry;         // a failed polled read is back in the queue since then
    Boxed<Triggering> trigger;            // where it has one
    bool triggered = false;
    unsigned refusals = 0;  // in a row, of a read that bridges gaps
    bool under_way = false;
    bool by_trigger = false;  // of the transaction under way
    Instant last_start = Instant::min();
    Instant round = Instant::min();  // what it reads belongs to the period with this instant

    [[nodiscard]] wire::Pdu pdu() const;
};

/// How a request writes.
enum class WriteKind : std::uint8_t {
    whole,     // all members with 0x05, 0x06, 0x0F, 0x10
    mask,      // bits of one register with 0x16
    modify,    // bits of one register: read, then written with 0x06 or 0x10
    exchange,  // with 0x17, which reads too
};

/// Where a read-modify-write stands.
struct Modify {
    bool reading = false;              // the read is under way
    std::optional<std::uint16_t> old;  // it was read: now the write, before anything else
};

/// The write half.
struct WriteJob {
    wire::Function function = wire::Function::write_multiple_registers;
    WriteKind kind = WriteKind::whole;
    std::vector<std::size_t> members;  // what is written: indices into Run::variables_
    bus::AnswerShape shape;
    std::size_t rank = 0;
    bool asked = false;        // by set(), or again after a failure of what was not asked by commands alone
    bool triggered = false;    // by its trigger
    std::size_t commands = 0;  // by so many commands that are not under way
    Admittance admittance;
    std::uint16_t failures = 0;
    Backoff busy = busy_backoff();
    Instant not_before = Instant::min();
    bool told_waiting = false;
    bool under_way = false;
    std::vector<std::size_t> sending;  // bits under way
    bool sent_asked = false;           // what is under way was asked for not by commands alone
    std::uint64_t sent_want = 0;       // Run::last_want_ when it was last sent,
    std::uint64_t settled_want = 0;    // and when what was last settled was
    Modify modify;
    std::unique_ptr<ReadBack> read_back;  // where some of it is verified
    bus::TimeStatistics read_time;        // of the read half, whose counters are also those of the writes

    [[nodiscard]] bool due() const { return asked || triggered || commands > 0; }
    /// It writes single bits of a register, and leaves the others as they are.
    [[nodiscard]] bool writes_bits() const { return kind == WriteKind::mask || kind == WriteKind::modify; }
};

struct RequestRun {
    const plan::Request* plan = nullptr;
    std::size_t device = 0;
    std::vector<std::size_t> variables;       // indices into Run::variables_
    std::vector<model::LocalIndex> statuses;  // the different ones of its variables
    std::optional<ReadJob> read;
    std::unique_ptr<WriteJob> write;  // few requests write
    value::Reason last_reason = value::Reason::ok;
    bus::TransactionCounters counters;
    std::uint64_t skipped = 0;  // releases

    [[nodiscard]] const bus::TimeStatistics& read_time() const {
        return write ? write->read_time : counters.time;
    }
};

struct DeviceRun {
    const model::Device* model = nullptr;
    std::vector<std::size_t> requests;
    Duration wait{};
    Health health{1};
    bool enabled = true;
    std::uint16_t in_flight = 0;  // transactions
    std::uint16_t most_in_flight = 1;
    bool writing = false;  // one of them writes; writes keep their order
    bool has_reads = false;
    DeviceStatistics statistics;
};

/// Whether anything but a probe may be asked of it: it is switched on, and answers. Without reads there are
/// no probes; then what is to be written takes their place.
inline bool reachable(const DeviceRun& device) {
    return device.enabled && (device.health.answering() || !device.has_reads);
}

/// No further transaction is taken.
inline bool full(const DeviceRun& device) {
    return device.in_flight >= device.most_in_flight;
}

/// What is to be known of a variable that can be written.
struct WrittenRun {
    std::optional<std::size_t> change_group;   // the request that writes it on change
    std::optional<std::size_t> trigger_group;  // the request that writes it by a trigger
    bool pending = false;                      // a bit to be written by set(), or again: not under way yet
    bool sent_pending = false;                 // it was when it was sent
    value::Value last_read;
    value::Value sending;    // of one that is not read: as it was last sent with its group
    std::uint64_t want = 0;  // which order its wanted value comes from
};

struct VariableRun {
    const model::Variable* model = nullptr;
    value::SlotId slot;
    std::uint32_t device = 0;
    std::optional<std::uint32_t> split;   // index into Run::splits_
    std::unique_ptr<WrittenRun> written;  // where it can be
    PeriodMeter meter{Duration::zero()};
};

/// A command that waits or is under way: written with the group `group`, or alone.
struct PendingCommand {
    value::WriteCommand command;
    std::size_t variable = 0;
    bool rounded = false;
    std::uint64_t order = 0;
    std::optional<std::size_t> group;
    value::Value wanted_before;  // to be restored where nothing was sent
    std::uint64_t want = 0;      // VariableRun::want by this command, and before
    std::uint64_t want_before = 0;
    // alone:
    wire::Pdu pdu;  // of a read-modify-write: its read
    wire::Function function = wire::Function::write_multiple_registers;
    bool modifies = false;
    Modify modify;
    std::optional<std::size_t> bucket_of;  // the request whose bucket it passes
    bool admitted = false;
    bus::AnswerShape shape;
    std::uint16_t failures = 0;
    Backoff busy = busy_backoff();
    Instant not_before = Instant::min();
    bool in_flight = false;
    bool sent = false;                 // at least once
    bool carried = false;              // its value goes with the group under way
    bool maybe_done = false;           // an attempt left that open, or did what is repeated for others
    bool confirmed = false;            // it was done with a group whose other members differ
    std::unique_ptr<ReadBack> verify;  // of a command alone
    value::Value read_back;            // where it differs from what was written

    /// Nothing of it is under way.
    [[nodiscard]] bool may_start() const { return !in_flight || (verify && verify->due); }
};

/// What stands at the front of the queue, and how the candidates compare: by class, then by time, then by
/// place.
inline constexpr std::int64_t kNoDeadline = std::numeric_limits<std::int64_t>::max();
enum class Urgency : std::uint8_t { commanded, relayed, overdue, polled, background };
enum class JobKind : std::uint8_t { read, group_write, command, trial, relayed };
struct Candidate {
    Urgency urgency = Urgency::background;
    std::int64_t key = 0;
    std::uint64_t place = 0;
    JobKind kind = JobKind::read;
    std::uint64_t index = 0;  // request, or for a command its order
    bool by_trigger = false;

    [[nodiscard]] bool before(const Candidate& other) const {
        if (urgency != other.urgency) return urgency < other.urgency;
        return key != other.key ? key < other.key : place < other.place;
    }
};

/// How long a connection on which no device answers may say nothing before it is made anew.
inline constexpr Backoff kConnectionSilence{std::chrono::seconds(30), std::chrono::minutes(10)};

constexpr bool writes(JobKind kind) {
    return kind == JobKind::group_write || kind == JobKind::command;
}

constexpr bus::TransactionId transaction_id(JobKind kind, std::uint64_t index) {
    return index << 3 | static_cast<std::uint64_t>(kind);
}

constexpr JobKind kind_of(bus::TransactionId id) {
    return static_cast<JobKind>(id & 7);
}

/// The shape of the answer to a write of one register.
constexpr bus::AnswerShape written_shape(wire::Function function) {
    return {static_cast<std::uint8_t>(function), 5};
}

/// How an outcome is treated: what the user is told, and whether it was an answer of the device.
struct Verdict {
    value::Reason reason = value::Reason::ok;
    bool answered = false;  // the device itself said something
    bool busy = false;      // exceptions 5 and 6
};
Verdict verdict_of(const bus::Outcome& outcome);
/// Of the read before a write that does not follow: the device was switched off meanwhile, or what it says.
Verdict unwritten(const Verdict& verdict);

/// What the engine of a line works in: as much as its framing and its requests in flight need.
class EngineRoom {
public:
    /// @param longest_pdu  of the requests and responses there will be
    EngineRoom(const bus::LineConfig& config, std::size_t longest_pdu);
    [[nodiscard]] bus::TransactionRoom room();

private:
    std::vector<bus::TransactionSlot> slots_;
    std::vector<std::uint8_t> bytes_;  // of the slots, for sending, for receiving
    std::size_t longest_pdu_;
    std::size_t sending_;
    std::unique_ptr<bus::LateAnswers> late_answers_;
};

/// What a line that learns is about (trials.cpp, replan.cpp).
struct Study {
    Learning learning;
    PlanMaker* plan_maker = nullptr;
    plan::LinePlan plan;                             // that runs
    std::optional<std::vector<plan::Trial>> trials;  // of the first plan
    bool plan_wanted = false;                        // and not given yet
    std::optional<plan::LearningPlan> next_plan;     // to be run as soon as nothing is under way
    std::optional<Learning::Question> question;      // what is to be tried next, or is being tried
    std::optional<Instant> waiting_since;            // for a quiet moment to ask it
    Instant last_start = Instant::min();
};

/// What others send over the line.
struct RelayRun {
    bus::TokenBucket bucket;                      // of those that go ahead of polling
    std::optional<bus::Transaction> transaction;  // waits or is under way
    std::optional<std::size_t> device;            // to which it is sent, where it is one of the project
    bool only_reads = false;
    bool under_way = false;
    bool admitted = false;  // by the bucket
    Instant last_start = Instant::min();
    std::optional<bus::Outcome> outcome;  // not taken yet
};

class LinePoller::Run final : private Witness {
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
    const plan::LinePlan* plan_;
    const ProjectSlots& slots_;
    value::Store& store_;
    PollObserver* observer_;
    EngineRoom engine_room_;
    bus::TransactionCore engine_;

    std::vector<VariableRun>
        variables_;  // in the order of the project: slots first_slot_, first_slot_ + 1, ...
    std::uint32_t first_slot_ = 0;
    std::vector<DeviceRun> devices_;
    std::vector<RequestRun> requests_;
    std::vector<PendingCommand> commands_;
    std::list<value::CommandOutcome> outcomes_;  // takes no room while it is empty
    std::optional<Instant> up_since_;
    bool connection_silent_ = false;  // it is up, and nobody says anything: to be made anew
    Duration busy_time_{};
    std::unique_ptr<Study> study_;     // of a line that learns
    std::unique_ptr<RelayRun> relay_;  // of a line that is shared

    Result<void> relay(Instant t, const bus::Transaction& transaction);

private:
    // run.cpp
    void add_variables();
    void add_requests();
    void add_read(std::size_t request);
    void add_write(std::size_t request);
    void add_parts(std::size_t request);

    // restart.cpp
    [[nodiscard]] Health fresh_health(const DeviceRun& device) const;
    void restart_device(Instant t, DeviceRun& device, bool at_once);
    void release_at_once(Instant t, const DeviceRun& device);
    void set_device_state(Instant t, std::size_t device, DeviceState state);
    void judge_connection(Instant t);
    void switch_device(Instant t, std::size_t device, bool on);
    void pull_trigger(Instant t, std::size_t request, model::LocalIndex local);
    void take_outcomes();

    // schedule.cpp
    void choose(Instant t);
    void consider(Instant t, UnitId unit, const bus::AnswerShape& shape, Instant due,
                  const Candidate& candidate, std::optional<Candidate>& best);
    void consider_all(Instant t, std::optional<Candidate>& best);
    void consider_event(Instant t, std::size_t request, std::optional<Candidate>& best);
    void consider_triggered(Instant t, std::size_t request, std::optional<Candidate>& best);
    void consider_polled(Instant t, std::size_t request, std::optional<Candidate>& best);
    [[nodiscard]] static Instant polling_due(const ReadJob& read);
    [[nodiscard]] static Instant waits_since(const ReadJob& read);
    void consider_write(Instant t, std::size_t request, std::optional<Candidate>& best);
    void consider_probe(Instant t, std::size_t device, std::optional<Candidate>& best);
    void consider_command(Instant t, PendingCommand& command, std::optional<Candidate>& best);
    [[nodiscard]] Candidate commanded(const Admittance& admittance, std::size_t request,
                                      std::size_t rank) const;
    [[nodiscard]] bool overdue(Instant t, Instant since, Duration allowed) const;
    [[nodiscard]] Instant overdue_after(Instant since, Duration allowed) const;
    [[nodiscard]] Candidate polling_rank(Instant t, std::size_t request) const;
    void start(Instant t, const Candidate& candidate);
    void start_read(Instant t, std::size_t request, bool by_trigger);
    void start_group(Instant t, std::size_t request);
    void note_sending(const WriteJob& write);
    void start_command(Instant t, PendingCommand& command);
    void note_start(Instant t, std::size_t request);
    void submit(Instant t, std::size_t device, bus::TransactionId id, Purpose purpose, const wire::Pdu& pdu);
    void tell_sending(Instant t, std::size_t device, bus::TransactionId id, Purpose purpose);
    void wake_at(Instant t);

    void on_outcome(const bus::Outcome& outcome);

    // ready.cpp
    void make_queue();
    void touch(std::size_t request);
    [[nodiscard]] Instant line_free() const;
    [[nodiscard]] std::optional<Standing> standing(Instant t, std::size_t request) const;
    void consider_first(Instant t, std::optional<Candidate>& best);
    void consider_first_of(Instant t, std::size_t device, std::optional<Candidate>& best);
    void check_choice(Instant t, const std::optional<Candidate>& chosen);

    // trials.cpp
    void begin_learning(const plan::LinePlan& plan, const Options& options);
    [[nodiscard]] bool keep_learning(Instant t);
    void consider_trial(Instant t, std::optional<Candidate>& best);
    void start_trial(Instant t);
    void on_trial(const bus::Outcome& outcome);
    void tell_lessons(Instant t);
    [[nodiscard]] Fresh look(std::size_t device, wire::Function read, const model::ItemRange& items,
                             Instant since) const override;
    [[nodiscard]] bool fits_before_polling(Instant t, const Learning::Question& question) const;
    [[nodiscard]] std::vector<model::ItemRange> bridged_gaps(const RequestRun& request) const;
    bool refused_with_gaps(const bus::Outcome& outcome, RequestRun& request, value::Reason reason);

    // relayed.cpp
    void share_line();
    void consider_relayed(Instant t, std::optional<Candidate>& best);
    void start_relayed(Instant t);
    void on_relayed(bus::Outcome outcome);
    void drop_relayed(Instant t);

    // replan.cpp
    void swap_plan(Instant t);
    void end_overruns(Instant t, const plan::LinePlan& next);
    void carry_read(Instant t, std::vector<RequestRun>& old, std::size_t request);
    void carry_triggers(const std::vector<RequestRun>& old, RequestRun& request);
    void carry_write(const std::vector<RequestRun>& old, std::size_t request);
    void carry_commands();
    void keep_due(Instant t, const std::vector<RequestRun>& old);

    // outcomes.cpp
    Verdict judge(const bus::Outcome& outcome, std::size_t device, bus::TransactionCounters* counters);
    void on_read(const bus::Outcome& outcome, std::size_t request);
    void take_values(Instant t, RequestRun& request, const wire::Request& asked, Bytes pdu);
    void on_exchanged(const bus::Outcome& outcome, const Verdict& verdict, RequestRun& request);
    void take_value(RequestRun& request, const wire::Response& response, std::size_t variable);
    void take_part(RequestRun& request, const wire::Response& response, std::size_t variable);
    void note_value(VariableRun& variable, const Result<value::Value>& value);
    [[nodiscard]] std::optional<std::int64_t> round_of(const RequestRun& request,
                                                       const VariableRun& variable) const;
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
    void settle_group(Instant t, std::size_t request, const Verdict& verdict, const WriteVerdict& what);
    void settle_command(Instant t, std::uint64_t order, const Verdict& verdict, const WriteVerdict& what);
    static WriteVerdict judge_write(const bus::Outcome& outcome, const Verdict& verdict, bool safe_to_repeat);
    static WriteVerdict judge_unwritten(const Verdict& verdict);
    bool may_repeat(const DeviceRun& device, const Verdict& verdict, std::uint16_t& failures) const;
    void on_group_written(const bus::Outcome& outcome, std::size_t request);
    void note_carried(std::size_t device, bool sent);
    void refuse_outdated(Instant t, std::size_t request);
    void queue_again(Instant t, std::size_t request);
    void tell_group_settled(Instant t, std::size_t request, value::CommandResult result,
                            value::Reason reason);
    void finish_group(Instant t, std::size_t request, value::CommandResult result, value::Reason reason);
    void show_written(Instant t, std::size_t variable, const value::Value& value);
    [[nodiscard]] Result<std::size_t> writable(value::SlotId slot) const;
    [[nodiscard]] std::size_t index_in_device(std::size_t variable) const;
    [[nodiscard]] const value::Value* value_to_write(std::size_t variable) const;
    [[nodiscard]] bool repeatable(std::span<const std::size_t> variables) const;
    void ask_group(Instant t, std::size_t request);
    bool group_ready(Instant t, std::size_t request);
    Result<wire::Pdu> group_pdu(const RequestRun& request);

    // commands.cpp
    Result<void> prepare_alone(PendingCommand& command);
    void on_command_written(const bus::Outcome& outcome, std::uint64_t order);
    PendingCommand& command_of(std::uint64_t order);
    void withdraw(Instant t, const PendingCommand& command, value::CommandResult unsent,
                  value::Reason reason);
    void finish(Instant t, const PendingCommand& command, value::CommandResult result, value::Reason reason);
    void forget_wanted(const PendingCommand& command);
    void supersede(Instant t, std::size_t variable, const value::Value& value);
    void drop_pending(Instant t, std::size_t device, value::Reason reason);
    void expire_commands(Instant t);

    // modify.cpp
    /// A read-modify-write whose register was read: its write goes before everything else.
    struct Continuation {
        JobKind kind = JobKind::group_write;
        std::uint64_t index = 0;  // as in Candidate
        std::size_t device = 0;
        bus::AnswerShape shape;
    };
    [[nodiscard]] bool to_be_written(std::size_t variable) const;
    [[nodiscard]] const std::vector<std::size_t>& bits_to_write(const WriteJob& write);
    [[nodiscard]] Result<RegisterBits> bits_of(std::span<const std::size_t> variables);
    [[nodiscard]] Result<wire::Pdu> written_back();
    bool take_old(const bus::Outcome& outcome, const Verdict& verdict, const Continuation& next,
                  Modify& modify);
    void go_on(Instant t);
    void abandon(Instant t, value::Reason reason, bool again);

    // verify.cpp
    void await_read_back(std::size_t device, ReadBack& back, std::uint64_t order);
    void consider_read_back(Instant t, std::size_t device, const ReadBack& back, Candidate candidate,
                            std::optional<Candidate>& best);
    void start_read_back(Instant t, std::size_t device, bus::TransactionId id, ReadBack& back);
    bool take_read_back(const bus::Outcome& outcome, const ReadBack& back, std::size_t device,
                        std::span<const std::size_t> variables);
    bool read_back_again(Instant t, std::size_t device, const Verdict& verdict, ReadBack& back);
    void on_group_read_back(const bus::Outcome& outcome, std::size_t request);
    void on_command_read_back(const bus::Outcome& outcome, const Verdict& verdict, std::uint64_t order);
    void drop_read_backs(Instant t, std::size_t device, value::Reason reason);

    std::unique_ptr<ReadQueue> queue_;   // of lines with many requests
    std::vector<std::size_t> eventful_;  // with it: the requests that have a trigger or write
    std::optional<Continuation> continuation_;
    std::vector<SplitValue> splits_;
    Instant epoch_;                      // of the grid of all periods
    Instant heard_at_ = Instant::min();  // the last byte of this connection, or its beginning
    Backoff silence_allowed_ = kConnectionSilence;
    Duration silence_limit_ = silence_allowed_.next();
    std::int64_t last_trigger_ = 0;
    bool modifying_ = false;         // from the read of a read-modify-write to its write nothing else is sent
    int patience_ = 1;               // deadlines that polling waits before it is overdue
    std::vector<std::size_t> bits_;  // scratch
    std::size_t cursor_ = 0;         // order: address: the place in the round
    std::uint64_t last_order_ = 0;
    std::uint64_t last_want_ = 0;
    Instant wakeup_ = kNever;  // of the schedule alone, as of the last transmit()
    bool polling_due_ = false;
    std::vector<value::Update> updates_;  // scratch, so that a transaction allocates nothing
    std::vector<Member> members_;         // likewise
    std::vector<std::size_t> told_;       // likewise
};

}  // namespace takt::poll
