// The command line as a client of a host: the host polls on its I/O thread, this thread prints and takes commands.
#include "takt/app/run_project.hpp"

#include <unistd.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "endpoint_face.hpp"
#include "run_view.hpp"
#include "session_commands.hpp"
#include "takt/app/console.hpp"
#include "takt/app/control_server.hpp"
#include "takt/app/log.hpp"
#include "takt/app/project.hpp"
#include "takt/app/traffic_log.hpp"
#include "takt/host/project_host.hpp"
#include "takt/line/descriptors.hpp"
#include "takt/line/loop.hpp"
#include "takt/report/event_report.hpp"
#include "work_loop.hpp"

namespace takt::app {
namespace {

constexpr Duration kRefreshEvery = std::chrono::milliseconds(200);

bool has_access_rules(const model::Project& project) {
    return std::ranges::any_of(project.servers,
                               [](const model::Server& server) { return !server.access.empty(); });
}

std::string json_gap_line(std::uint64_t missed) {
    return report::missed_json(missed).dump() + '\n';
}
std::string text_gap_line(std::uint64_t missed) {
    return "… " + std::to_string(missed) + "\n";
}

os::WriterOptions writer_options(bool json) {
    os::WriterOptions options;
    options.gap_line = json ? json_gap_line : text_gap_line;
    return options;
}

/// Everything of a run, in the order in which it is made and (backwards) destroyed.
class Run {
public:
    Run(const Texts& texts, const RunOptions& options)
        : texts_(texts), options_(options), out_(STDOUT_FILENO, writer_options(options.json)) {}

    Result<void> begin(const model::Project& project, const plan::Plan& plan, const PrepareDevices& prepare) {
        std::function<void()> reload;
        if (has_access_rules(project)) reload = [this] { reload_access(); };
        TAKT_CHECK(work_loop_.begin(options_.traffic, std::move(reload)));
        TAKT_TRY(host_, host::ProjectHost::start(project, plan, host_options(prepare)));
        TAKT_TRY(session_, host_->open_session({.traffic = work_loop_.traffic() != nullptr, .from_beginning = true}));
        if (work_loop_.traffic()) tap_.emplace(*work_loop_.traffic());
        make_view();
        TAKT_CHECK(begin_commands());
        auto& loop = work_loop_.loop();
        readable_ = std::make_unique<line::Watch>(loop, session_->descriptor(), [this] { read_session(); });
        refresh_ = std::make_unique<line::Timer>(loop, [this](Instant t) { refresh(t); });
        refresh_->set(line::now());
        read_session();
        return {};
    }

    void work() {
        work_loop_.work(options_.run_for);
        host_->stop();
        if (control_commands_) control_commands_->take_outcomes();
        read_session();
        print_served();
        if (const auto last = session_->snapshot({.values = true, .statistics = true})) view_->end(*last);
        // After Ctrl-C a slow reader has half a second; at the end of a run it has time.
        out_.finish(work_loop_.loop().stopped() ? std::chrono::milliseconds(500) : std::chrono::seconds(10));
        note_stdout_error(out_.error());
    }

private:
    [[nodiscard]] host::HostOptions host_options(const PrepareDevices& prepare) const {
        host::HostOptions options;
        options.project_file = options_.file;
        options.state_file = options_.state;
        options.learn = options_.learn;
        options.learnt_file = options_.learnt;
        options.record_traffic = !options_.traffic.empty();
        options.prepare = prepare;
        options.log = log;
        return options;
    }

    // If the file cannot be used, the old rules stay in force.
    void reload_access() {
        const auto loaded = load_project(options_.file);
        if (!loaded.has_errors() && host_->set_access(loaded.project)) return;
        print_status(findings_text(texts_, loaded));
        print_error(texts_("app.access.kept", {{"file", options_.file}}));
    }

    void print_served() {
        const auto& project = host_->configuration()->project();
        if (project.servers.empty()) return;
        if (options_.json)
            out_.put_last(report::served_json(summary_of(host_->served()), "served") +
                          relayed_json(project, host_->served()));
        else
            print_status(report::served_text(texts_, summary_of(host_->served())) +
                         relayed_text(texts_, project, host_->served()));
    }

    void make_view() {
        const bool in_place = ::isatty(STDOUT_FILENO) != 0 && !options_.commands_from_stdin;
        view_ = options_.json ? make_json_view(host_->started(), texts_, out_)
                : in_place    ? make_live_view(*session_, texts_, out_)
                              : make_line_view(texts_, out_);
    }

    // Control clients have a session of their own: a write of theirs that fails is also an event for the view.
    Result<void> begin_commands() {
        auto& loop = work_loop_.loop();
        commands_.emplace(*session_, texts_, [&loop] { loop.stop(); });
        if (options_.commands_from_stdin)
            stdin_ = std::make_unique<StdinCommands>(
                loop, executed_by(*commands_), texts_,
                [this](const Answer& answer) { view_->on_answer(line::now(), answer); });
        if (options_.control_path.empty()) return {};
        TAKT_TRY(control_session_, host_->open_session({.events = false}));
        control_commands_.emplace(*control_session_, texts_, [&loop] { loop.stop(); });
        control_readable_ = std::make_unique<line::Watch>(loop, control_session_->descriptor(), [this] {
            read_control_session();
        });
        read_control_session();
        TAKT_TRY(control_,
                 ControlServer::listen(loop, options_.control_path, executed_by(*control_commands_), texts_));
        return {};
    }

    static Execute executed_by(SessionCommands& commands) {
        return [&commands](const std::string& line, const Reply& reply) { return commands.execute(line, reply); };
    }

    void read_control_session() {
        do control_commands_->take_outcomes();
        while (control_session_->rearm() && !work_loop_.loop().stopped());
        control_readable_->want_read();
    }

    // Outcomes first: the answer to a command comes before the values that it changed.
    void read_session() {
        do {
            commands_->take_outcomes();
            while (const auto event = session_->next_event()) on_event(*event);
            const auto missed = session_->missed_events();
            if (missed > missed_) view_->on_missed(missed - std::exchange(missed_, missed));
            while (const auto record = session_->next_traffic()) tap_->put(*session_, *record);
        } while (session_->rearm() && !work_loop_.loop().stopped());
        readable_->want_read();
    }

    // A failed write that standard input asked for is reported once, by its answer.
    void on_event(const host::Event& event) {
        const auto* const notice = std::get_if<host::Notice>(&event.body);
        if (notice) return print_notice(texts_, *notice);
        const auto* const finished = std::get_if<host::WriteFinished>(&event.body);
        if (finished && finished->session == session_->id()) return;
        view_->on_event(*session_->configuration(), event);
    }

    void refresh(Instant t) {
        if (out_.closed()) return work_loop_.loop().stop();  // the reader is gone (takt run … | head)
        view_->refresh();
        refresh_->set(after(t, kRefreshEvery));
    }

    Texts texts_;
    const RunOptions& options_;
    os::LineWriter out_;
    WorkLoop work_loop_;
    std::unique_ptr<host::ProjectHost> host_;
    std::unique_ptr<host::Session> session_;
    std::unique_ptr<RunView> view_;
    std::optional<SessionCommands> commands_;
    std::unique_ptr<host::Session> control_session_;
    std::optional<SessionCommands> control_commands_;
    std::optional<TapLog> tap_;
    std::unique_ptr<ControlServer> control_;
    std::unique_ptr<StdinCommands> stdin_;
    std::unique_ptr<line::Watch> readable_;
    std::unique_ptr<line::Watch> control_readable_;
    std::unique_ptr<line::Timer> refresh_;
    std::uint64_t missed_ = 0;
};

// Each line that is not simulated has one; the program needs further ones for the terminal, logs, the loop and
// control clients.
constexpr std::size_t kOwnDescriptors = 64;

bool enough_descriptors(const Texts& texts, const model::Project& project) {
    const auto real = std::ranges::count_if(
        project.lines, [](const model::Line& line) { return line.transport != model::Transport::simulated; });
    const std::size_t needed = static_cast<std::size_t>(real) + kOwnDescriptors;
    const std::size_t allowed = line::raise_descriptor_limit();
    if (needed <= allowed) return true;
    const Texts::Arguments arguments{{"needed", std::to_string(needed)},
                                     {"allowed", std::to_string(allowed)}};
    print_error(texts("app.run.descriptors", arguments));
    print_status("    " + texts("app.run.descriptors.advice", arguments) + '\n');
    return false;
}

}  // namespace

ExitCode run_project(const Texts& texts, const model::Project& project, const plan::Plan& plan,
                     const RunOptions& options, const PrepareDevices& prepare) {
    if (!enough_descriptors(texts, project)) return ExitCode::cannot_open;
    Run run(texts, options);
    if (const auto begun = run.begin(project, plan, prepare); !begun) return ended_by(texts, begun.error());
    run.work();
    return ExitCode::ok;
}

}  // namespace takt::app
