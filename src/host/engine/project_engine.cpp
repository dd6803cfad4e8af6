// One turn of a project, in this order (io_thread.cpp calls it): a driver or a request gives bytes, ticks or
// commands to the engines; the endpoints see the event and may submit relayed requests; the driver sends;
// then publish() settles commands, moves the value events of the store into the ring of the host, and wakes
// the sessions. Observer callbacks of the engines append to the ring at once.
#include "engine/project_engine.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <variant>

#include "sessions/record_codec.hpp"

namespace takt::host {
namespace {

constexpr std::size_t kScratchWords = 1024;  // longer than any event of a steady state

LogLevel level_of(const Outcome& outcome) {
    return outcome.result == value::CommandResult::done ? LogLevel::info : LogLevel::warning;
}

}  // namespace

/// The facts of service variables at one moment.
class ProjectEngine::RunFacts final : public value::ServiceFacts {
public:
    RunFacts(const ProjectEngine& engine, Instant t) : engine_(engine), t_(t) {}

    [[nodiscard]] std::uint64_t utc_seconds() const override {
        return engine_.utc_seconds_ ? engine_.utc_seconds_() : 0;
    }
    [[nodiscard]] Duration uptime() const override { return t_ - engine_.started_; }
    [[nodiscard]] bool first_cycle_is_over() const override { return engine_.first_cycle_is_over(); }
    [[nodiscard]] value::LineFacts line(std::size_t line) const override {
        const auto statistics = engine_.master_.line(line).statistics(t_);
        return {.up = engine_.lines_[line].up,
                .load = statistics.recent_utilization,
                .cycle = statistics.measured_cycle,
                .requests = statistics.counters.sent,
                .errors = errors(statistics.counters)};
    }
    [[nodiscard]] value::DeviceFacts device(std::size_t line, std::size_t device) const override {
        const auto& statistics = engine_.master_.line(line).device(device);
        const auto& counters = statistics.counters;
        return {.state = static_cast<std::uint16_t>(statistics.state),
                .answering = statistics.state == poll::DeviceState::answering,
                .response_time = statistics.recent_time,
                .requests = counters.sent,
                .errors = errors(counters),
                .timeouts = counters.timeouts,
                .checksum_errors = counters.checksums,
                .exceptions = counters.exceptions,
                .outages = statistics.outages};
    }

private:
    [[nodiscard]] static std::uint64_t errors(const bus::TransactionCounters& counters) {
        return counters.timeouts + counters.checksums + counters.unexpected + counters.ambiguous +
               counters.link_lost;
    }

    const ProjectEngine& engine_;
    Instant t_;
};

static_assert(static_cast<int>(poll::DeviceState::unknown) == 0 &&
                  static_cast<int>(poll::DeviceState::answering) == 1 &&
                  static_cast<int>(poll::DeviceState::not_answering) == 2 &&
                  static_cast<int>(poll::DeviceState::switched_off) == 3 &&
                  static_cast<int>(poll::DeviceState::link_down) == 4,
              "the numbers of system.device.NAME.state in docs/service-variables.md");

ProjectEngine::ProjectEngine(HostLink& link, ConfigurationPtr configuration, const Options& options)
    : link_(link),
      configuration_(std::move(configuration)),
      retention_(options.retention),
      learner_(options.learner),
      started_(options.started),
      log_(options.log),
      failures_(options.log, configuration_->project()),
      utc_seconds_(options.utc_seconds),
      lines_(configuration_->project().lines.size()),
      master_(configuration_->project(), configuration_->plan(), master_options(options)),
      commands_(*configuration_, master_, retention_, *this),
      guests_(
          master_, [this](std::unique_ptr<CommandRequest> command) { on_finished(std::move(command)); },
          [this](std::size_t line) {
              if (poke_) poke_(line);
          }),
      services_(configuration_->project(), configuration_->slots()) {
    record_.reserve(kScratchWords);
    fills_.reserve(HostLink::kMostSessions);
    for (std::size_t i = 0; i < lines_.size(); ++i) {
        // The other lines share the plan of the configuration.
        lines_[i].plan =
            learner_ && plan::learns(configuration_->project().lines[i])
                ? std::make_shared<const plan::LinePlan>(master_.line(i).plan())
                : std::shared_ptr<const plan::LinePlan>(configuration_, &configuration_->plan().lines[i]);
        lines_[i].plan_revision = master_.line(i).plan_revision();
        lines_[i].changes.resize(configuration_->project().lines[i].devices.size());
        lines_[i].fails_often.resize(lines_[i].changes.size());
    }
}

ProjectEngine::~ProjectEngine() = default;

poll::Master::Options ProjectEngine::master_options(const Options& options) {
    poll::Master::Options result;
    result.observer = this;
    result.line_traffic = options.line_traffic;
    result.line_bus = options.line_bus;
    if (retention_) result.restored = retention_->restored();
    result.restored_at = options.restored_at;
    result.learn = learner_ != nullptr;
    result.plan_maker = learner_;
    return result;
}

void ProjectEngine::on_link(Instant t, std::size_t line, bool up, const std::optional<Error>& why) {
    if (up) {
        end_link_failures(t, line);
        failures_.on_link_up(t, line);
        log_.message(
            LogLevel::info, "log.link_up",
            std::array{LogArgument{.name = "line", .text = configuration_->project().lines[line].name}});
    }
    // A failed attempt leaves the engine as it was; its variables are to show that there is no link.
    if (!up) master_.line(line).on_link(t, false);
    lines_[line].up = up;
    lines_[line].why = up ? std::nullopt : why;
    if (up) {
        publish_event(t, LinkChanged{.line = line, .up = true});
        return;
    }
    const LinkFailure failure{why};
    end_link_failures(t, line, &failure);
    if (lines_[line].failures.admit(t, failure)) report_link(t, line, failure, 0, {});
}

void ProjectEngine::report_link(Instant t, std::size_t line, const LinkFailure& failure,
                                std::uint64_t repeated, Duration in) {
    failures_.on_link_down(line, failure.why, repeated, in);
    publish_event(t, LinkChanged{.line = line, .why = failure.why, .repeated = repeated, .in = in});
}

void ProjectEngine::end_link_failures(Instant t, std::size_t line, const LinkFailure* current) {
    lines_[line].failures.end(
        t, [current](const LinkFailure& failure) { return current == nullptr || failure != *current; },
        [&](const LinkFailure& failure, std::uint64_t repeated, Duration in) {
            report_link(t, line, failure, repeated, in);
        });
}

void ProjectEngine::report_links(Instant t, bool finish) {
    const auto omitted = [](std::uint64_t, Duration) {};  // none: a line has one reason at a time
    for (std::size_t line = 0; line < lines_.size(); ++line) {
        const auto report = [&](const LinkFailure& failure, std::uint64_t repeated, Duration in) {
            report_link(t, line, failure, repeated, in);
        };
        auto& failures = lines_[line].failures;
        finish ? failures.finish(t, report, omitted) : failures.sweep(t, report, omitted);
    }
}

void ProjectEngine::on_close(Instant t, std::size_t line, const std::optional<Error>& why) {
    if (why) failures_.on_link_closed(t, line, *why);
}

void ProjectEngine::on_closed_in_pause(std::size_t line, Duration open_for) const {
    const auto& settings = configuration_->project().lines[line];
    const auto after = milliseconds_number(open_for);
    const auto pause = milliseconds_number(settings.connection.pause_after);
    log_.message(LogLevel::warning, "log.closed_in_pause",
                 std::array{LogArgument{.name = "line", .text = settings.name},
                            LogArgument{.name = "milliseconds", .text = after},
                            LogArgument{.name = "pause", .text = pause}});
}

bool ProjectEngine::serve(Instant t) {
    while (auto request = link_.requests.take()) {
        auto* const served = request.get();
        served->serve(*this, t, std::move(request));
    }
    std::erase_if(fills_, [&](const auto& fill) { return !fill->fill_slice(*this, t); });
    return !fills_.empty();
}

void CommandRequest::serve(ProjectEngine& engine, Instant t, std::unique_ptr<HostRequest> self) {
    std::unique_ptr<CommandRequest> own(static_cast<CommandRequest*>(self.release()));
    engine.execute(t, std::move(own));
}

// The slot of another generation may be another variable.
void ProjectEngine::execute(Instant t, std::unique_ptr<CommandRequest> command) {
    if (command->generation == configuration_->generation()) {
        if (command->command.kind == Command::Kind::exchange) return guests_.execute(t, std::move(command));
        return commands_.execute(t, std::move(command));
    }
    command->outcome.t = t;
    command->outcome.error = fail(Code::not_found, "variable of another project").error();
    on_finished(std::move(command));
}

void ProjectEngine::publish(Instant t) {
    commands_.settle();
    guests_.settle(t);
    const auto& store = master_.store();
    while (const auto* event = store.next_event(cursor_)) {
        if (const auto missed = std::exchange(cursor_.missed, 0); missed > 0)
            publish_event(event->t, EventsLost{.count = missed});  // they were before this one
        record_.clear();
        encode(configuration_->generation(), *event, record_);
        link_.events.append(record_);
    }
    for (std::size_t i = 0; i < lines_.size() && learner_; ++i) follow_plan(i);
    link_.notify();
}

void ProjectEngine::publish_event(Instant t, decltype(Event::body) body) {
    record_.clear();
    encode(Event{.generation = configuration_->generation(), .t = t, .body = std::move(body)}, record_);
    link_.events.append(record_);
}

// A device without polled requests counts as asked, and so does one that is switched off.
bool ProjectEngine::first_cycle_is_over() const {
    for (std::size_t l = 0; l < lines_.size(); ++l) {
        const auto& poller = master_.line(l);
        const auto& requests = poller.plan().requests;
        for (std::size_t r = 0; r < requests.size(); ++r)
            if (requests[r].read && requests[r].period && poller.request(r).counters.sent == 0 &&
                poller.device(requests[r].device).state != poll::DeviceState::switched_off)
                return false;
    }
    return true;
}

value::Value ProjectEngine::service_value(Instant t, const model::ServiceVariable& variable) const {
    return value::service_value(variable, RunFacts(*this, t));
}

// An unchanged value becomes younger. It is no change for the lines.
void ProjectEngine::update_services(Instant t) {
    if (services_.empty()) return;
    for (const auto& [slot, value] : services_.update(RunFacts(*this, t))) {
        const auto& now = master_.store()[slot];
        if (now.quality == value::Quality::good && value::same(now.value, value)) {
            const value::Update update{.slot = slot};
            master_.store().apply(t, {&update, 1});
        } else if (master_.set(t, slot, value)) {
            on_changed(slot);
        }
    }
}

Instant ProjectEngine::next_tick(Instant t) const {
    if (services_.empty()) return after(t, kTickEvery);
    return after(started_, value::ServiceValues::next_update(t - started_));
}

void ProjectEngine::on_tick(Instant t) {
    commands_.on_tick(t);
    guests_.settle(t);
    update_services(t);
    failures_.on_tick(t);
    report_links(t);
    end_changes(t);
    if (log_.enabled()) log_frequent_failures();
    if (retention_) retention_->on_tick(t);
    if (learner_) learner_->on_tick(t);
    // A driver whose line is not open has no wake-ups; commands expire all the same.
    for (std::size_t i = 0; i < lines_.size(); ++i)
        if (!lines_[i].up) master_.line(i).on_tick(t);
}

void ProjectEngine::replace_plan(std::size_t line, plan::LearningPlan plan,
                                 std::shared_ptr<const plan::LinePlan> copy) {
    lines_[line].next_plan = std::move(copy);
    master_.line(line).replace_plan(std::move(plan));
    if (poke_) poke_(line);
}

// The poller swaps plans when nothing is in flight; the shared copy follows.
void ProjectEngine::follow_plan(std::size_t line) {
    auto& state = lines_[line];
    if (!state.next_plan || state.plan_revision == master_.line(line).plan_revision()) return;
    state.plan_revision = master_.line(line).plan_revision();
    state.plan = std::exchange(state.next_plan, nullptr);
}

std::shared_ptr<const plan::LinePlan> ProjectEngine::running_plan(std::size_t line) const {
    return lines_[line].plan;
}

Result<bool> ProjectEngine::set_local(Instant t, value::SlotId slot, const value::Value& value) {
    const auto rounded = master_.set(t, slot, value);
    if (rounded) on_changed(slot);
    return rounded;
}

// A command for a line that is not open must not be written when the line opens.
Result<bool> ProjectEngine::write_value(Instant t, value::SlotId slot, const value::Value& value,
                                        CommandExecutor::Written written) {
    const auto owner = configuration_->slots().owner(slot);
    const auto* const index = std::get_if<value::VariableIndex>(&owner);
    if (index && !lines_[index->line].up)
        return fail(Code::connection_lost, configuration_->project().lines[index->line].name);
    return commands_.write(t, ++link_.last_command, slot, value, std::move(written));
}

// The outcomes of the old poller are known only after it was taken over: its waiting commands have expired
// then.
void ProjectEngine::take_over(Instant t, ProjectEngine& old,
                              const std::vector<std::optional<std::size_t>>& continued) {
    old.publish(t);
    const auto restored = master_.take_over_values(old.master_);
    while (master_.store().next_event(cursor_)) {  // of restored values, whether or not they stayed
    }
    for (const auto id : restored) {
        const auto& slot = master_.store()[id];
        publish_event(t, ValueChanged{.slot = id,
                                      .value = slot.value,
                                      .quality = slot.quality,
                                      .reason = slot.reason,
                                      .good_at = slot.good_at,
                                      .sampled_at = slot.sampled_at,
                                      .good_before = {},
                                      .batch = slot.batch});
    }
    for (std::size_t i = 0; i < continued.size(); ++i) {
        if (!continued[i]) continue;
        master_.line(i).take_over(t, old.master_.line(*continued[i]));
        lines_[i].up = old.lines_[*continued[i]].up;
        lines_[i].why = old.lines_[*continued[i]].why;
        if (lines_[i].why) (void)lines_[i].failures.admit(t, {lines_[i].why});  // it was reported
    }
    old.end_writes(t);
    old.failures_.finish(t);
    old.report_links(t, true);
    old.end_changes(t, true);
    old.commands_.finish(t);
    old.guests_.finish(t);
    old.commands_.abandon_kept();
    fills_ = std::move(old.fills_);
}

// A write that was never sent has expired; one that may have been executed is unknown.
void ProjectEngine::end_writes(Instant t) {
    for (std::size_t i = 0; i < lines_.size(); ++i) master_.line(i).end_writes(t);
    publish(t);
}

void ProjectEngine::finish(Instant t) {
    end_writes(t);
    failures_.finish(t);
    report_links(t, true);
    end_changes(t, true);
    commands_.finish(t);
    guests_.finish(t);
    if (learner_) learner_->finish(t);
    if (retention_) retention_->finish();
    commands_.abandon_kept();
    publish(t);
}

RequestKey ProjectEngine::key_of(std::size_t line, std::size_t request) const {
    const auto& planned = master_.line(line).plan().requests[request];
    return {line, planned.device, planned.read, planned.write, planned.start, planned.quantity};
}

void ProjectEngine::on_device_state(Instant t, std::size_t line, std::size_t device, poll::DeviceState state,
                                    value::Reason failure) {
    DeviceStateChanged changed{line, device, state, failure};
    // Lost links and devices that are switched off have messages of their own; an unknown one is asked at
    // once.
    if (state == poll::DeviceState::answering || state == poll::DeviceState::not_answering) {
        auto& filter = lines_[line].changes[device];
        end_changes(t, line, device);
        changed.shown = filter.changed(t);
        changed.changes = filter.count();
        changed.in = filter.in();
    }
    publish_state(t, changed);
    if (state == poll::DeviceState::unknown) return;
    if (state != poll::DeviceState::answering) commands_.on_device_unavailable(line, device);
}

void ProjectEngine::publish_state(Instant t, const DeviceStateChanged& changed) {
    using Shown = DeviceStateChanged::Shown;
    if (log_.enabled() && changed.shown != Shown::counted) {
        auto message = event_message(*configuration_, changed);
        message.code = "log.device_state";
        const bool not_answering = changed.state == poll::DeviceState::not_answering;
        const bool trouble = changed.shown == Shown::each ? not_answering : changed.shown == Shown::often;
        write_log(trouble ? LogLevel::warning : LogLevel::info, message);
    }
    if (changed.state != poll::DeviceState::unknown) publish_event(t, changed);
}

void ProjectEngine::end_changes(Instant t, std::size_t line, std::size_t device, bool finish) {
    auto& filter = lines_[line].changes[device];
    using Shown = DeviceStateChanged::Shown;
    if (filter.ended(t, finish))
        publish_state(t, {line, device, master_.line(line).device(device).state,
                          master_.line(line).device(device).failure,
                          filter.quiet(t) ? Shown::steady : Shown::total, filter.count(), filter.in()});
}

void ProjectEngine::end_changes(Instant t, bool finish) {
    for (std::size_t i = 0; i < lines_.size(); ++i)
        for (std::size_t d = 0; d < lines_[i].changes.size(); ++d) end_changes(t, i, d, finish);
}

// When it begins and when it ends: single failures are in the log besides.
void ProjectEngine::log_frequent_failures() {
    for (std::size_t i = 0; i < lines_.size(); ++i)
        for (std::size_t d = 0; d < lines_[i].fails_often.size(); ++d) {
            const auto device = master_.line(i).device(d);
            const bool refuses = device.refusals.state() == poll::FailureShare::State::failing;
            const auto& share = refuses ? device.refusals : device.share;
            const bool often = share.state() == poll::FailureShare::State::failing;
            if (often == lines_[i].fails_often[d]) continue;
            lines_[i].fails_often[d] = often;
            const auto& line = configuration_->project().lines[i];
            EventMessage message{.code = !often    ? "log.often.ended"
                                         : refuses ? "log.often.refused"
                                                   : "log.often.failed",
                                 .arguments = {{.name = "line", .text = line.name},
                                               {.name = "device", .text = line.devices[d].name},
                                               {.name = "count", .text = std::to_string(share.failed())},
                                               {.name = "of", .text = std::to_string(share.transactions())}}};
            if (refuses)
                append_exception_words(message.arguments, most_frequent_exception(device.counters), "why");
            write_log(often ? LogLevel::warning : LogLevel::info, message);
        }
}

void ProjectEngine::on_overrun(Instant t, std::size_t line, std::size_t request, Duration period,
                               Duration real, bool overrun) {
    const PeriodOverrun event{key_of(line, request), period, real, overrun};
    log_event(overrun ? LogLevel::warning : LogLevel::info, event);
    publish_event(t, event);
}

void ProjectEngine::on_delays(Instant t, std::size_t line, std::size_t device,
                              const poll::DelayFinding& finding) {
    const DelaysFound event{line, device, finding};
    log_event(LogLevel::warning, event);
    publish_event(t, event);
}

void ProjectEngine::on_measured(Instant t, std::size_t /*line*/, std::size_t /*device*/) {
    if (learner_) learner_->on_measured(t);
}

void ProjectEngine::on_lengths_off(Instant t, std::size_t line) {
    if (learner_) learner_->on_learnt(t);
    log_.message(LogLevel::warning, "log.lengths_off",
                 std::array{LogArgument{.name = "line", .text = configuration_->project().lines[line].name}});
}

void ProjectEngine::on_noise(Instant t, std::size_t line, std::size_t device,
                             const poll::NoiseFinding& finding) {
    const NoiseFound event{line, device, finding};
    log_event(LogLevel::warning, event);
    publish_event(t, event);
}

void ProjectEngine::on_surplus(Instant t, std::size_t line, std::size_t device) {
    const SurplusFound event{line, device};
    log_event(LogLevel::warning, event);
    publish_event(t, event);
}

void ProjectEngine::on_group_settled(Instant t, const poll::SettledGroup& settled) {
    commands_.on_group_settled(t, settled);
}

void ProjectEngine::on_write_waiting(Instant t, std::size_t line, std::size_t request, std::size_t variable) {
    const WriteWaiting event{key_of(line, request), variable};
    log_event(LogLevel::warning, event);
    publish_event(t, event);
    commands_.on_device_unavailable(line, event.request.device);
}

void ProjectEngine::on_failed(Instant t, std::size_t line, const poll::FailedExchange& failed) {
    failures_.on_failed(t, line, failed);
}

void ProjectEngine::on_learnt(Instant t, std::size_t line, const poll::GapEvent& gap_event) {
    const GapLearnt event{line, gap_event};
    log_event(LogLevel::info, event);
    if (learner_) learner_->on_learnt(t);
    publish_event(t, event);
}

void ProjectEngine::on_verify_failed(Instant t, std::size_t line, std::size_t device, std::size_t variable,
                                     const value::Value& written, const value::Value& read) {
    const auto slot = configuration_->slots().variable({line, device, variable});
    commands_.on_verify_failed(t, slot, written, read);
    const VerifyFailed event{slot, written, read};
    log_event(LogLevel::warning, event);
    publish_event(t, event);
}

void ProjectEngine::on_changed(value::SlotId slot) {
    if (!poke_) return;
    for (const auto line : master_.concerned(slot)) poke_(line);
}

void ProjectEngine::on_finished(std::unique_ptr<CommandRequest> command) {
    link_.deliver(std::move(command));
}

void ProjectEngine::on_write_finished(const Outcome& outcome, SessionId session) {
    log_event(level_of(outcome), outcome);
    publish_event(outcome.t, WriteFinished{outcome, session});
}

void ProjectEngine::on_client_write_finished(const Outcome& outcome) {
    if (!log_.enabled()) return;
    auto message = event_message(*configuration_, outcome);
    for (auto& argument : message.arguments)
        if (argument.name == "cause") argument.text = "app.write.by_client";
    write_log(level_of(outcome), message);
}

void ProjectEngine::write_log(LogLevel level, const EventMessage& message) const {
    if (message.code.empty()) return;
    std::vector<LogArgument> arguments;
    append(arguments, message.arguments);
    arguments.push_back({.name = "where", .text = "log.device", .is_code = true});
    log_.message(level, message.code, arguments);
}

}  // namespace takt::host
