#include "takt/console/host_console.hpp"

#include <utility>

#include "takt/console/notices.hpp"
#include "takt/report/states/serve_report.hpp"

namespace takt::console {
namespace {

constexpr Duration kRefreshEvery = std::chrono::milliseconds(200);
constexpr Duration kLossesEvery = std::chrono::minutes(1);

Execute executed_by(SessionCommands& commands) {
    return [&commands](const std::string& line, const Reply& reply, const Texts& texts) {
        return commands.execute(line, reply, texts);
    };
}

/// Whose device the event is; nothing: it concerns none, or several.
const model::Device* device_of(const host::Configuration& configuration, const host::Event& event) {
    const auto device = [&](std::size_t line, std::size_t index) {
        return &configuration.project().lines[line].devices[index];
    };
    if (const auto* const e = std::get_if<host::ValueChanged>(&event.body))
        return configuration.device_of(e->slot);
    if (const auto* const e = std::get_if<host::DeviceStateChanged>(&event.body))
        return device(e->line, e->device);
    if (const auto* const e = std::get_if<host::PeriodOverrun>(&event.body))
        return device(e->request.line, e->request.device);
    if (const auto* const e = std::get_if<host::WriteWaiting>(&event.body))
        return device(e->request.line, e->request.device);
    if (const auto* const e = std::get_if<host::VerifyFailed>(&event.body))
        return configuration.device_of(e->slot);
    return nullptr;
}

/// Whether there are devices to choose from.
bool has_devices(const model::Project& project) {
    std::size_t devices = 0;
    for (const auto& line : project.lines) devices += line.devices.size();
    return devices > 1;
}

}  // namespace

HostConsole::HostConsole(const Texts& texts, Environment environment, Options options)
    : texts_(texts), environment_(std::move(environment)), options_(std::move(options)) {}

Result<void> HostConsole::begin() {
    auto& loop = environment_.loop;
    TAKT_TRY(session_,
             environment_.open_session({.traffic = environment_.traffic != nullptr, .from_beginning = true}));
    if (environment_.traffic) tap_.emplace(*environment_.traffic);
    make_view();
    TAKT_CHECK(begin_commands());
    readable_.emplace(loop, session_->descriptor(), [this] { read_session(); });
    refresh_.emplace(loop, [this](Instant t) { refresh(t); });
    refresh_->set(line::now());
    read_session();
    return {};
}

void HostConsole::make_view() {
    auto& out = environment_.out;
    view_ = options_.json ? make_json_view(environment_.started, texts_, out)
            : options_.in_place && !options_.quiet
                ? make_live_view(*session_, texts_, out, options_.screen,
                                 {.device = options_.device,
                                  .takes_keys = options_.keys.has_value(),
                                  .has_devices = has_devices(session_->configuration()->project())},
                                 environment_.outputs)
                : make_line_view(texts_, out, options_.screen);
    if (!options_.keys) return;
    keyboard_.emplace(environment_.loop, *options_.keys, [this](const Key& key) {
        if (!view_->on_key(key)) environment_.loop.stop();
    });
}

bool HostConsole::is_shown(const host::Event& event) {
    const auto& configuration = *session_->configuration();
    const bool is_value = std::holds_alternative<host::ValueChanged>(event.body);
    if (!options_.device.empty()) {
        const auto* const device = device_of(configuration, event);
        if (device ? device->name != options_.device : is_value) return false;
    }
    const bool live = options_.in_place && !options_.json;
    if (!options_.quiet && !live) return true;
    const auto* const link = std::get_if<host::LinkChanged>(&event.body);
    if (!link) return !options_.quiet || !is_value;
    return link->repeated == 0;  // it changed the state
}

// Control clients have a session of their own: a write of theirs that fails is also an event for the view.
Result<void> HostConsole::begin_commands() {
    auto& loop = environment_.loop;
    const auto quit = [&loop] { loop.stop(); };
    commands_.emplace(*session_, quit);
    commands_->set_outputs(environment_.outputs);
    if (options_.commands)
        input_.emplace(loop, *options_.commands, executed_by(*commands_), texts_,
                       [this](const Answer& answer) { view_->on_answer(line::now(), answer); });
    if (options_.control_path.empty()) return {};
    TAKT_TRY(control_session_, environment_.open_session({.events = false}));
    control_commands_.emplace(*control_session_, quit);
    control_commands_->set_outputs(environment_.outputs);
    control_readable_.emplace(loop, control_session_->descriptor(), [this] { read_control_session(); });
    read_control_session();
    TAKT_TRY(control_,
             ControlServer::listen(loop, options_.control_path, executed_by(*control_commands_), texts_));
    return {};
}

void HostConsole::end(const endpoint::Statistics& served) {
    if (control_commands_) control_commands_->take_outcomes();
    read_session();
    put_served(served);
    if (const auto last = session_->snapshot({.values = true, .statistics = true, .times = true}))
        view_->end(*last,
                   environment_.outputs ? environment_.outputs() : std::vector<publish::OutputStatus>());
}

void HostConsole::put_served(const endpoint::Statistics& served) {
    const auto& project = session_->configuration()->project();
    if (project.servers.empty()) return;
    if (options_.json)
        environment_.out.put_last(report::served_json(served, "served") +
                                  report::relayed_json(project, served));
    else
        environment_.messages.status(report::served_text(texts_, served) +
                                     report::relayed_text(texts_, project, served));
}

void HostConsole::read_control_session() {
    do control_commands_->take_outcomes();
    while (control_session_->rearm() && !environment_.loop.stopped());
    control_readable_->want_read();
}

// Outcomes first: the answer to a command comes before the values that it changed.
void HostConsole::read_session() {
    const LineOf line_of = [this](const host::TrafficRecord& record) { return session_->line_of(record); };
    do {
        commands_->take_outcomes();
        while (const auto event = session_->next_event()) on_event(*event);
        const auto missed = session_->missed_events();
        if (missed > missed_) view_->on_missed(missed - std::exchange(missed_, missed));
        while (const auto record = session_->next_traffic()) tap_->put(*record, line_of);
    } while (session_->rearm() && !environment_.loop.stopped());
    readable_->want_read();
}

// A failed write that the input asked for is reported once, by its answer.
void HostConsole::on_event(const host::Event& event) {
    if (const auto* const notice = std::get_if<host::Notice>(&event.body)) {
        put_notice(texts_, environment_.messages, *notice);
        if (!options_.json) return;
    }
    const auto* const finished = std::get_if<host::WriteFinished>(&event.body);
    if (finished && finished->session == session_->id()) return;
    if (!is_shown(event)) return;
    view_->on_event(*session_->configuration(), event);
}

// A full disk is reported when it begins; the count of lost lines follows in the output itself.
void HostConsole::report_output() {
    const int error = environment_.out.error();
    if (error == std::exchange(output_error_, error) || error == 0) return;
    const Error why = fail(Code::io_failed, "stdout", error).error();
    environment_.messages.error(texts_("app.output.full", {{"why", texts_.describe(why)}}));
}

void HostConsole::report_outputs(Instant t) {
    if (!environment_.outputs) return;
    for (const auto& status : environment_.outputs()) {
        const OutputSummary summary{
            status.state,    status.failure,   status.journal_failure, status.disk_waits > Duration{},
            status.gaps > 0, status.set_aside, status.damaged};
        const auto [known, first] = outputs_.try_emplace(status.name);
        auto& shown = known->second;
        const bool grows = status.samples.dropped != shown.dropped && t >= shown.at + kLossesEvery;
        if (!first && !grows && summary == shown.summary) continue;
        shown = {summary, status.samples.dropped, t};
        view_->on_output(t, status);
    }
}

void HostConsole::refresh(Instant t) {
    if (environment_.out.closed()) return environment_.loop.stop();  // the reader is gone (takt run … | head)
    report_output();
    report_outputs(t);
    if (keyboard_) keyboard_->renew();
    view_->refresh();
    refresh_->set(after(t, kRefreshEvery));
}

}  // namespace takt::console
