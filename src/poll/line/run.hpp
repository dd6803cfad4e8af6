// The implementation of LinePoller: it owns the engine, the tables and the parts of a line, hands events to
// the parts, and sends what the arbiter chooses (run.cpp, restart.cpp, start.cpp, distinct.cpp, outcomes.cpp,
// ages.cpp, delays.cpp, writes.cpp, commands.cpp, modify.cpp, verify.cpp, relayed.cpp, trials.cpp,
// replan.cpp, take_over.cpp). The parts are listed in docs/architecture.md, "The parts of the poller".
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "devices/close_watch.hpp"
#include "devices/exchange_times.hpp"
#include "devices/link_watch.hpp"
#include "devices/load_meter.hpp"
#include "devices/outcome_class.hpp"
#include "devices/statuses.hpp"
#include "learning/gap_learner.hpp"
#include "line/engine_buffers.hpp"
#include "line/line_match.hpp"
#include "line/relay_slot.hpp"
#include "line/request_offers.hpp"
#include "line/tables.hpp"
#include "line/transfer.hpp"
#include "reads/age_watch.hpp"
#include "reads/distinct_reads.hpp"
#include "reads/period_watch.hpp"
#include "reads/read_schedule.hpp"
#include "reads/value_publisher.hpp"
#include "takt/bus/transaction_engine.hpp"
#include "takt/plan/request_job.hpp"
#include "takt/poll/line_poller.hpp"
#include "writes/command_queue.hpp"
#include "writes/modify_sequence.hpp"
#include "writes/write_groups.hpp"
#include "writes/write_job.hpp"

namespace takt::poll {

class LinePoller::Run final : private FreshnessProbe {
public:
    Run(const model::Project& project, const plan::LinePlan& plan, const value::ProjectSlots& slots,
        value::Store& store, const Options& options);

    void on_link(Instant t, bool up);
    void on_close(Instant t);
    [[nodiscard]] bool must_reconnect() const;
    [[nodiscard]] bool lengths_are_off() const;
    [[nodiscard]] std::optional<Error> rejection() const { return engine_.rejection(); }
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
    const value::ProjectSlots& slots_;
    value::Store& store_;
    PollObserver* observer_;
    EngineBuffers engine_buffers_;
    bus::TransactionCore engine_;

    std::vector<VariableRun> variables_;  // in the order of the project
    std::uint32_t first_slot_ = 0;        // that of the first variable; the others follow it
    std::vector<DeviceRun> devices_;
    std::size_t held_reads_ = 0;  // of all devices
    std::vector<RequestRun> requests_;
    WrittenValues written_values_;
    CommandQueue commands_;
    ArrivalCounter arrivals_;
    ReadSchedule reads_;
    WriteGroups write_groups_;
    DistinctReads distinct_reads_;
    ValuePublisher publisher_;
    Statuses statuses_;
    PeriodWatch periods_;
    ExchangeTimes exchange_times_;
    LinkWatch link_;
    CloseWatch closes_;
    LoadMeter load_;
    AvailabilityMeter availability_;
    std::unique_ptr<GapLearner> learner_;  // if the line learns
    std::uint64_t plan_revision_ = 0;      // grows with each swap_plan()
    bool lengths_reported_ = false;        // that headers have lengths that are off by one
    bool suspended_ = false;               // nothing is polled any more
    std::unique_ptr<RelaySlot> relay_;     // if the line is shared

    void admit_guests();
    Result<void> relay(Instant t, const bus::Transaction& transaction, bool spare);

    // take_over.cpp
    void hold();
    [[nodiscard]] bool quiet() const;
    [[nodiscard]] bool idle() const;
    void end_writes(Instant t);
    void take_over(Instant t, Run& old);

private:
    // run.cpp
    void add_variables();
    [[nodiscard]] bool switched_on(const model::Device& device) const;
    [[nodiscard]] std::optional<std::size_t> device_at(UnitId unit) const;
    void add_requests();
    void add_read(std::size_t request, const std::optional<plan::RequestJob>& polled,
                  const std::optional<plan::RequestJob>& triggered);
    void add_write(std::size_t request, const plan::RequestJob& planned);

    // restart.cpp
    void restart_device(Instant t, std::size_t device);
    void resume_device(std::size_t device);
    void link_opened(Instant t);
    void link_lost(Instant t);
    [[nodiscard]] bool spare(Instant t, const bus::TransactionCore::Awaited& waiting);
    void set_device_state(Instant t, std::size_t device, DeviceState state);
    void check_connection(Instant t);
    void switch_device(Instant t, std::size_t device, bool on);
    void pull_trigger(Instant t, std::size_t request, model::LocalIndex local);
    void refuse_trigger(Instant t, std::size_t request, model::LocalIndex local);
    void take_outcomes();
    void observe_line(Instant t);

    // start.cpp
    void choose(Instant t);
    void offer(Instant t);
    void look_ahead(Instant t);
    [[nodiscard]] bool may_submit() const;
    void start(Instant t, const Candidate& candidate);
    void start_read(Instant t, std::size_t request, bool by_trigger);
    void start_write(Instant t, bus::TransactionId id);
    void submit(Instant t, std::size_t device, bus::TransactionId id, Purpose purpose,
                const wire::PreparedRequest& request);
    void report_failure(const bus::Outcome& outcome);
    void report_sending(Instant t, std::size_t device, bus::TransactionId id, Purpose purpose);
    [[nodiscard]] bool* unlimited_event(bus::TransactionId id);
    void on_outcome(const bus::Outcome& outcome);

    // trials.cpp
    void begin_learning(const plan::LinePlan& plan, const Options& options);
    [[nodiscard]] bool keep_learning(Instant t);
    void offer_trial(Instant t);
    void start_trial(Instant t);
    void on_trial(const bus::Outcome& outcome);
    void report_gap_events(Instant t);
    [[nodiscard]] Freshness freshness(std::size_t device, wire::Function read, const model::ItemRange& items,
                                      Instant since) const override;
    [[nodiscard]] bool fits_before_polling(Instant t, const Learning::TrialRead& trial_read) const;
    [[nodiscard]] std::vector<model::ItemRange> bridged_gaps(const RequestRun& request) const;
    bool refused_with_gaps(const bus::Outcome& outcome, std::size_t request, value::Reason reason);

    // relayed.cpp
    void share_line();
    void offer_relayed(Instant t);
    void offer_spare_relayed(Instant t);
    [[nodiscard]] bool device_takes_relayed(Instant t) const;
    void put_offer_of_relayed(Instant t);
    void start_relayed(Instant t);
    void on_relayed(const bus::Outcome& outcome);
    void give_up_relayed(Instant t, bus::Status status);

    // ages.cpp
    void make_ages();
    [[nodiscard]] std::optional<Duration> greatest_age(std::size_t variable) const;
    void expire_ages(Instant t);
    void report_overrun(Instant t, std::size_t request, bool overrun);
    void report_overruns(Instant t);

    // replan.cpp
    void swap_plan(Instant t);
    void end_overruns(Instant t, const plan::LinePlan& next);
    struct OldReads;
    void carry_read(Instant t, const OldReads& old, std::size_t request);
    void carry_triggers(const OldReads& old, std::size_t request);
    void carry_write(const std::vector<RequestRun>& old,
                     const std::vector<std::unique_ptr<WriteGroup>>& old_groups, std::size_t request);
    void carry_commands();

    // take_over.cpp
    void take_over_device(Instant t, Run& old, const LineMatch& match, std::size_t device);
    void take_over_variable(const Run& old, const LineMatch& match, std::size_t variable);
    void take_over_read(Instant t, const Run& old, const LineMatch& match, std::size_t request);
    void take_over_write(const Run& old, const LineMatch& match, std::size_t request);

    // distinct.cpp
    /// How long a response of the device is waited for.
    void set_times(const DeviceRun& device, bus::Transaction& transaction) const;
    bool on_part(const bus::Outcome& outcome, const OutcomeClass& outcome_class, std::size_t request);
    /// The values that may come from late responses, because the device does not answer in order.
    void note_in_step(const bus::Outcome& outcome);
    void on_surplus(const bus::SurplusFrame& frame);
    struct Surplus {
        Instant at;
        std::size_t device = 0;
        bool shifted = false;  ///< no repetition
    };
    void count_surplus(const Surplus& found);
    void take_values(const bus::Outcome& outcome, std::size_t request, const wire::RequestShape& sent,
                     bool whole);
    void show_doubt(const HeldRead& read);
    void publish_read(const HeldRead& read, value::Quality quality);
    [[nodiscard]] std::optional<value::Quality> quality_of(Instant t, std::size_t device,
                                                           const bus::Outcome& read) const;
    void pop_held(std::size_t device, value::Quality quality);
    void settle_held(Instant t, std::size_t device);
    void settle_held(Instant t);
    void give_up_held(std::size_t device);
    void give_up_held();
    /// When settle_held() is due.
    [[nodiscard]] Instant held_until() const;
    /// The read of the request has brought no values.
    void degrade_read(Instant t, std::size_t request, value::Quality quality, value::Reason reason,
                      Shown shown);
    void degrade_shifted(Instant t, const DeviceRun& device, const bus::AnswerShape& shape, Instant since);

    // outcomes.cpp
    OutcomeClass note_outcome(const bus::Outcome& outcome, std::size_t device, RequestRun* request);
    void count_outcome(std::size_t device, const bus::Outcome& outcome);
    void note_busy(const bus::Outcome& outcome);
    void on_read(const bus::Outcome& outcome, std::size_t request);
    void on_exchanged(const bus::Outcome& outcome, const OutcomeClass& outcome_class, std::size_t request);
    void fail_read(const bus::Outcome& outcome, std::size_t request, value::Reason reason);
    void degrade_device(Instant t, std::size_t device, value::Reason reason, Shown shown);

    // delays.cpp
    void begin_measuring(DeviceRun& device);
    void on_late(const bus::LateResponse& late);
    void measure_delay(std::size_t device, const bus::Outcome& outcome, bool answered);
    void report_delay(Instant t, std::size_t device, const std::optional<DelayFinding>& found);

    // writes.cpp
    [[nodiscard]] WriteJob write_job(bus::TransactionId id);
    void on_written(const bus::Outcome& outcome);
    void set_write_status(Instant t, const WriteJob& write, value::Reason reason);
    void settle_write(Instant t, WriteJob write, const OutcomeClass& outcome_class, const WriteResult& what);
    void finish_write(Instant t, WriteJob write, value::CommandResult result, value::Reason reason);
    [[nodiscard]] Result<std::size_t> writable(value::SlotId slot) const;
    [[nodiscard]] std::size_t index_in_device(std::size_t variable) const;
    void report_waiting_writes(Instant t);

    // commands.cpp
    void drop_pending(Instant t, std::size_t device, value::Reason reason);

    // modify.cpp
    bool take_register(const bus::Outcome& outcome, const OutcomeClass& outcome_class, const WriteJob& write);
    void continue_modify(Instant t);
    void abandon(Instant t, value::Reason reason, bool again);

    // verify.cpp
    bool take_read_back(const bus::Outcome& outcome, const WriteJob& write);
    void on_read_back(const bus::Outcome& outcome, const OutcomeClass& outcome_class, WriteJob write);
    void drop_read_backs(Instant t, std::size_t device, value::Reason reason);

    const std::vector<std::vector<std::optional<Duration>>>* proved_ages_;  // of the first plan
    std::optional<AgeWatch> ages_;
    ModifySequence modify_;
    bus::Arbiter arbiter_;
    RequestOffers offers_;
    std::optional<Surplus> undecided_surplus_;  // unless another device answers with a wrong unit or function
    std::vector<std::size_t> settled_variables_;  // scratch, so that a transaction allocates nothing
};

}  // namespace takt::poll
