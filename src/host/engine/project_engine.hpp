// The I/O thread's side of a host: one project with its master, driven by bytes and time alone. Opens
// nothing, reads no clock and blocks nowhere, so that tests and the simulation drive it by hand.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "engine/change_filter.hpp"
#include "engine/host_link.hpp"
#include "engine/learning_planner.hpp"
#include "engine/line_guests.hpp"
#include "sessions/command_executor.hpp"
#include "sessions/failure_log.hpp"
#include "sessions/retention.hpp"
#include "sessions/snapshot_request.hpp"
#include "takt/base/engine.hpp"
#include "takt/base/log.hpp"
#include "takt/host/configuration.hpp"
#include "takt/host/event_message.hpp"
#include "takt/poll/master.hpp"
#include "takt/value/service_values.hpp"

namespace takt::host {

/// Runs the master of one configuration, publishes what it does, and serves the requests of sessions.
///
/// After every call of a line's engine, and after serve(), publish() is to be called soon: it hands on
/// outcomes and events. The I/O thread only.
class ProjectEngine final : private poll::PollObserver, private CommandSurroundings {
public:
    struct Options {
        Retention* retention = nullptr;                    ///< may be nullptr; outlives it
        LearningPlanner* learner = nullptr;                ///< nullptr: exactly the plan is run; outlives it
        std::vector<wire::TrafficObserver*> line_traffic;  ///< by line; outlive it
        std::vector<std::optional<bus::LineConfig>> line_bus;  ///< as of poll::Master::Options
        Instant started;                                       ///< of the host
        Instant restored_at;                         ///< when the values of the state file came into force
        std::function<std::uint64_t()> utc_seconds;  ///< since 1970, for system.time; empty: always 0
        Log log;
    };

    /// @param link  outlives it
    ProjectEngine(HostLink& link, ConfigurationPtr configuration, const Options& options);
    ~ProjectEngine();
    ProjectEngine(const ProjectEngine&) = delete;
    ProjectEngine& operator=(const ProjectEngine&) = delete;

    [[nodiscard]] const ConfigurationPtr& configuration() const { return configuration_; }
    [[nodiscard]] poll::Master& master() { return master_; }
    [[nodiscard]] const poll::Master& master() const { return master_; }
    [[nodiscard]] CommandExecutor& commands() { return commands_; }
    [[nodiscard]] const LineGuests& guests() const { return guests_; }
    [[nodiscard]] HostLink& link() { return link_; }
    [[nodiscard]] Instant started() const { return started_; }

    /// Which lines have something to do since a command; the driver of each is to be poked.
    using Poke = std::function<void(std::size_t line)>;
    void set_poke(Poke poke) { poke_ = std::move(poke); }

    /// Copies the counters of the endpoints into a snapshot's memory, without allocating.
    /// @returns false where the memory was made for other endpoints than `names`
    using EndpointCounters = std::function<bool(const EndpointNames& names, endpoint::Statistics& into)>;
    void set_endpoint_counters(EndpointCounters counters) { endpoint_counters_ = std::move(counters); }
    [[nodiscard]] bool copy_endpoints(const EndpointNames& names, endpoint::Statistics& into) const {
        return endpoint_counters_ ? endpoint_counters_(names, into) : !names;
    }

    /// Called by the driver's listener.
    void on_link(Instant t, std::size_t line, bool up, const std::optional<Error>& why);
    /// Likewise: the connection was closed and is opened again when a request is due.
    void on_close(Instant t, std::size_t line, const std::optional<Error>& why);
    /// The peer closed a connection before pause_after_connect ended.
    void on_closed_in_pause(std::size_t line, Duration open_for) const;
    [[nodiscard]] bool link_up(std::size_t line) const { return lines_[line].up; }
    /// Why the link is down; nothing: it is up, or nothing has happened yet.
    [[nodiscard]] const std::optional<Error>& link_error(std::size_t line) const { return lines_[line].why; }

    /// Serves the requests that have arrived. @returns whether some are unfinished: call again soon
    bool serve(Instant t);
    void execute(Instant t, std::unique_ptr<CommandRequest> command);
    void add_snapshot(std::unique_ptr<SnapshotFill> fill) { fills_.push_back(std::move(fill)); }

    /// Hands on outcomes and events. Steady state: no allocation, no lock.
    void publish(Instant t);
    /// An event that an engine did not cause.
    void publish_event(Instant t, decltype(Event::body) body);
    /// Event::number of the next event that is published.
    [[nodiscard]] std::uint64_t next_event() const { return link_.events.end().next; }

    /// Time-outs of commands, retained values, files, service variables. To be called at next_tick().
    void on_tick(Instant t);
    /// @param t  of the last on_tick()
    [[nodiscard]] Instant next_tick(Instant t) const;
    static constexpr Duration kTickEvery = std::chrono::milliseconds(200);
    /// Equal failures of a link are summarised after the first, and then after twice the time, up to the
    /// last.
    static constexpr Duration kLinkWindow = std::chrono::minutes(1);
    static constexpr Duration kLongestLinkWindow = std::chrono::hours(1);

    /// The value of a service variable at this moment, also of one that the project does not use.
    [[nodiscard]] value::Value service_value(Instant t,
                                             const model::ServiceVariable& variable) const override;

    /// A plan that the learner made.
    void replace_plan(std::size_t line, plan::LearningPlan plan, std::shared_ptr<const plan::LinePlan> copy);
    /// The plan that runs.
    [[nodiscard]] std::shared_ptr<const plan::LinePlan> running_plan(std::size_t line) const;

    /// Sets a local, or writes a variable, for a client of an endpoint. As poll::Master::set() and write();
    /// connection_lost while the variable's line is not open.
    [[nodiscard]] Result<bool> set_local(Instant t, value::SlotId slot, const value::Value& value);
    [[nodiscard]] Result<bool> write_value(Instant t, value::SlotId slot, const value::Value& value,
                                           CommandExecutor::Written written);

    /// Continues where `old`, whose lines are held and idle, is: values of the same name and type, and each
    /// line that continues one of `old` (by index). Commands that wait in `old` get their outcomes.
    void take_over(Instant t, ProjectEngine& old, const std::vector<std::optional<std::size_t>>& continued);

    /// The run ends: every command gets its outcome.
    void finish(Instant t);

private:
    struct LinkFailure {
        std::optional<Error> why;
        friend bool operator==(const LinkFailure& a, const LinkFailure& b) {
            return a.why && b.why ? FailureLog::same_error(*a.why, *b.why) : a.why == b.why;
        }
    };
    struct Line {
        bool up = false;
        std::optional<Error> why;                         // of a link that is down
        std::shared_ptr<const plan::LinePlan> plan;       // that runs
        std::shared_ptr<const plan::LinePlan> next_plan;  // that was given to the poller
        std::uint64_t plan_revision = 0;                  // of the poller, when `plan` was taken over
        std::vector<ChangeFilter> changes;                // by device
        std::vector<bool> fails_often;                    // by device: the log has it
        RepeatFilter<LinkFailure> failures{kLinkWindow, 1, kLongestLinkWindow};  // the last reason
    };

    void on_device_state(Instant t, std::size_t line, std::size_t device, poll::DeviceState state,
                         value::Reason failure) override;
    void on_overrun(Instant t, std::size_t line, std::size_t request, Duration period, Duration real,
                    bool overrun) override;
    void on_delays(Instant t, std::size_t line, std::size_t device,
                   const poll::DelayFinding& finding) override;
    void on_measured(Instant t, std::size_t line, std::size_t device) override;
    void on_lengths_off(Instant t, std::size_t line) override;
    void on_noise(Instant t, std::size_t line, std::size_t device,
                  const poll::NoiseFinding& finding) override;
    void on_surplus(Instant t, std::size_t line, std::size_t device) override;
    void on_group_settled(Instant t, const poll::SettledGroup& settled) override;
    void on_write_waiting(Instant t, std::size_t line, std::size_t request, std::size_t variable) override;
    void on_failed(Instant t, std::size_t line, const poll::FailedExchange& failed) override;
    void on_learnt(Instant t, std::size_t line, const poll::GapEvent& gap_event) override;
    void on_verify_failed(Instant t, std::size_t line, std::size_t device, std::size_t variable,
                          const value::Value& written, const value::Value& read) override;
    void on_changed(value::SlotId slot) override;
    void on_finished(std::unique_ptr<CommandRequest> command) override;
    void on_write_finished(const Outcome& outcome, SessionId session) override;
    void on_client_write_finished(const Outcome& outcome) override;

    template <class Event>
    void log_event(LogLevel level, const Event& event) const {
        if (log_.enabled()) write_log(level, event_message(*configuration_, event));
    }
    void write_log(LogLevel level, const EventMessage& message) const;

    void report_link(Instant t, std::size_t line, const LinkFailure& failure, std::uint64_t repeated,
                     Duration in);
    /// Ends the windows of the failures of a line except `current`: the next one of each is an event.
    void end_link_failures(Instant t, std::size_t line, const LinkFailure* current = nullptr);
    void report_links(Instant t, bool finish = false);
    void publish_state(Instant t, const DeviceStateChanged& changed);
    void end_changes(Instant t, std::size_t line, std::size_t device, bool finish = false);
    void end_changes(Instant t, bool finish = false);
    void log_frequent_failures();
    [[nodiscard]] poll::Master::Options master_options(const Options& options);
    class RunFacts;
    [[nodiscard]] bool first_cycle_is_over() const;
    [[nodiscard]] RequestKey key_of(std::size_t line, std::size_t request) const;
    void follow_plan(std::size_t line);
    void update_services(Instant t);
    void end_writes(Instant t);

    HostLink& link_;
    ConfigurationPtr configuration_;
    Retention* retention_;
    LearningPlanner* learner_;
    Instant started_;
    Log log_;
    FailureLog failures_;
    std::function<std::uint64_t()> utc_seconds_;
    std::vector<Line> lines_;
    poll::Master master_;
    CommandExecutor commands_;
    LineGuests guests_;
    value::ServiceValues services_;
    Poke poke_;
    EndpointCounters endpoint_counters_;
    value::EventCursor cursor_;
    std::vector<std::uint64_t> record_;  // scratch
    std::vector<std::unique_ptr<SnapshotFill>> fills_;
};

}  // namespace takt::host
