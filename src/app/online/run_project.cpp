// The command line as a client of a host: the host polls on its I/O thread, this thread prints and takes
// commands.
#include "online/run_project.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "log.hpp"
#include "offline/input_files.hpp"
#include "online/web_run.hpp"
#include "options/option_error.hpp"
#include "output.hpp"
#include "takt/console/capture_log.hpp"
#include "takt/console/host_console.hpp"
#include "takt/console/notices.hpp"
#include "takt/host/project_file.hpp"
#include "takt/host/project_host.hpp"
#include "takt/line/descriptors.hpp"
#include "takt/publish/outputs.hpp"
#include "takt/publish/project_outputs.hpp"
#include "work_loop.hpp"

namespace takt::app {
namespace {

// Two seconds for the disk, the rest for the destinations (kStopLimit of publish).
constexpr auto kDiskLimit = std::chrono::milliseconds(2700);
constexpr auto kDiskLimitOfARun = std::chrono::seconds(60);

/// Everything of a run, in the order in which it is made and (backwards) destroyed.
class Run {
public:
    Run(const Texts& texts, const RunOptions& options)
        : texts_(texts), options_(options), out_(STDOUT_FILENO, console::output_options(options.json)) {}

    /// @param token  of the page's API; empty: none
    Result<void> begin(const model::Project& project, const plan::Plan& plan, const PrepareDevices& prepare,
                       const std::string& token) {
        TAKT_CHECK(work_loop_.begin(options_.traffic, [this] { reload(); }, texts_));
        std::optional<console::CaptureFile> capture;  // a file that cannot be written starts no line
        if (!options_.capture.path.empty()) {
            TAKT_TRY(capture, console::CaptureFile::open(options_.capture));
        }
        TAKT_TRY(host_, host::ProjectHost::start(project, plan, host_options(prepare)));
        print_realtime(texts_, options_.realtime, realtime_.get_future().get(), options_.json);
        if (capture) TAKT_CHECK(begin_capture(*std::move(capture)));
        TAKT_CHECK(begin_outputs(project));
        console_.emplace(
            texts_,
            console::HostConsole::Environment{
                .loop = work_loop_.loop(),
                .out = out_,
                .messages = messages(),
                .traffic = work_loop_.traffic(),
                .open_session = [this](const auto& wanted) { return host_->open_session(wanted); },
                .started = host_->started(),
                .outputs = [this] { return outputs_status(); }},
            console_options());
        TAKT_CHECK(begin_web(token));
        return console_->begin();
    }

    /// @returns whether nothing is at work any more. If not, threads still use this object
    bool work() {
        work_loop_.work(options_.run_for);
        const bool ended = !web_ || web_->stop();
        host_->stop();
        capture_.reset();
        const bool stored = stop_outputs();
        console_->end(host_->served());
        // After Ctrl-C a slow reader has half a second; at the end of a run it has time.
        out_.finish(work_loop_.loop().stopped() ? std::chrono::milliseconds(500) : std::chrono::seconds(10));
        note_stdout_error(out_.error());
        if (!stored) leave();
        return ended;
    }

private:
    /// A disk that does not answer holds up the threads of the outputs. After Ctrl-C they have kDiskLimit.
    /// @returns false: they are still at work
    bool stop_outputs() {
        if (!outputs_) return true;
        const auto done = std::make_shared<std::promise<void>>();
        auto stopped = done->get_future();
        std::thread([this, done] {
            outputs_->stop();
            done->set_value();
        }).detach();
        const auto limit = work_loop_.loop().stopped() ? kDiskLimit : kDiskLimitOfARun;
        return stopped.wait_for(limit) == std::future_status::ready;
    }

    /// Ends the program without the threads that the disk holds up, and reports what they have not stored.
    [[noreturn]] void leave() {
        for (const auto& output : outputs_status())
            print_error(texts_("app.run.not_stored",
                               {{"name", output.name}, {"count", std::to_string(output.samples.waiting)}}));
        leave_program(texts_.language(), ExitCode::partly);
    }

    Result<void> begin_capture(console::CaptureFile file) {
        TAKT_TRY(auto session,
                 host_->open_session({.events = false, .traffic = true, .from_beginning = true}));
        capture_.emplace(std::move(file), console::tap_source(std::move(session)), file_reports(texts_));
        return {};
    }

    // Sampling costs time with each event: it begins with the first project that has outputs.
    Result<void> begin_outputs(const model::Project& project) {
        const std::scoped_lock lock(outputs_mutex_);
        if (outputs_ || project.outputs.empty()) return {};
        const auto open_session = [host = host_.get()](const host::SessionOptions& wanted) {
            return host->open_session(wanted);
        };
        TAKT_TRY(auto session, open_session({.from_beginning = true}));
        outputs_.emplace(std::move(session),
                         [options = publish::ProjectOutputsOptions{.project_file = options_.file,
                                                                   .open_session = open_session,
                                                                   .log = log}](const auto& configuration) {
                             return publish::project_outputs(options, configuration);
                         });
        return {};
    }

    Result<void> begin_web(const std::string& token) {
        if (!options_.web.address) return {};
        WebRun run{
            .project_file = options_.file,
            .host = {.open_session = [this](const auto& wanted) { return host_->open_session(wanted); },
                     .configuration = [this] { return host_->configuration(); },
                     .outputs = [this] { return outputs_status(); },
                     .started = host_->started()},
            .apply = [this](auto loaded) { return apply_saved(std::move(loaded)); }};
        TAKT_TRY(web_, start_web(texts_, options_.web, token, std::move(run)));
        return {};
    }

    /// On a thread of the page.
    Result<void> apply_saved(host::LoadedProject loaded) {
        if (!options_.learnt.empty()) static_cast<void>(host::recall_learnt(loaded, options_.file));
        log_findings(loaded.findings);
        return put_in_force(std::move(loaded));
    }

    // Planning takes this thread, which prints; polling goes on meanwhile.
    void reload() {
        if (options_.file.empty()) return print_status(texts_("app.run.no_file") + '\n');
        std::string learnt;  // the file stays that of the start
        auto loaded = load_to_run(texts_, options_.file, &learnt);
        if (!loaded) return print_error(texts_("app.run.kept", {{"file", options_.file}}));
        if (const auto applied = put_in_force(*std::move(loaded)); !applied)
            return print_error(texts_.describe(applied.error()));
        print_status(texts_("app.run.reloaded", {{"file", options_.file}}) + '\n');
    }

    /// Runs a project without errors in place of the one that runs. Any thread.
    [[nodiscard]] Result<void> put_in_force(host::LoadedProject loaded) {
        // At once: the rest waits for the transactions in flight.
        static_cast<void>(host_->set_access(loaded.project));
        auto plan = host::prove(loaded, false, false).plan;
        TAKT_CHECK(begin_outputs(loaded.project));
        return host_->apply(std::move(loaded.project), std::move(plan));
    }

    [[nodiscard]] std::vector<publish::OutputStatus> outputs_status() {
        const std::scoped_lock lock(outputs_mutex_);
        return outputs_ ? outputs_->status() : std::vector<publish::OutputStatus>();
    }

    [[nodiscard]] host::HostOptions host_options(const PrepareDevices& prepare) {
        host::HostOptions options;
        options.project_file = options_.file;
        options.state_file = options_.state;
        options.learn = options_.learn;
        options.learnt_file = options_.learnt;
        options.record_traffic = !options_.traffic.empty() || !options_.capture.path.empty();
        options.prepare = prepare;
        options.begin_thread = [this](line::Loop& loop) {
            realtime_.set_value(begin_realtime(options_.realtime, loop));
        };
        options.log = log;
        options.on_failed_start = [this](const auto& notice) {
            console::put_notice(texts_, messages(), notice);
        };
        return options;
    }

    [[nodiscard]] console::HostConsole::Options console_options() const {
        console::HostConsole::Options options;
        options.json = options_.json;
        options.quiet = options_.quiet;
        options.device = options_.device;
        const bool terminal = ::isatty(STDOUT_FILENO) == 1;
        options.in_place = terminal && !options_.commands_from_stdin && !options_.quiet && !options_.json;
        if (terminal) options.screen = [] { return screen_of(STDOUT_FILENO); };
        if (options.in_place && ::isatty(STDIN_FILENO) != 0) options.keys = STDIN_FILENO;
        if (options_.commands_from_stdin) options.commands = STDIN_FILENO;
        options.control_path = options_.control_path;
        return options;
    }

    Texts texts_;
    const RunOptions& options_;
    os::LineWriter out_;
    WorkLoop work_loop_;
    std::promise<std::vector<os::RealtimeResult>> realtime_;  // kept by the I/O thread
    std::unique_ptr<host::ProjectHost> host_;
    std::optional<console::CaptureLog> capture_;
    std::mutex outputs_mutex_;  // of the optional itself
    std::optional<publish::Outputs> outputs_;
    std::optional<console::HostConsole> console_;
    std::unique_ptr<WebSide> web_;
};

// Each line that is not simulated has one; the program needs further ones for the terminal, logs, the loop
// and control clients.
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

/// Reports a device that the project does not have.
bool is_device(const Texts& texts, const model::Project& project, const std::string& name) {
    std::string known;
    for (const auto& line : project.lines)
        for (const auto& device : line.devices) {
            if (device.name == name) return true;
            known += (known.empty() ? "" : ", ") + device.name;
        }
    print_error(option_error_text(texts, word_error("--device", name, known)));
    return false;
}

}  // namespace

ExitCode run_project(const Texts& texts, const model::Project& project, const plan::Plan& plan,
                     const RunOptions& options, const PrepareDevices& prepare) {
    if (!options.device.empty() && !is_device(texts, project, options.device)) return ExitCode::usage;
    if (!enough_descriptors(texts, project)) return ExitCode::cannot_open;
    const auto token = read_token(texts, options.web);
    if (!token) return ExitCode::usage;
    Run run(texts, options);
    if (const auto begun = run.begin(project, plan, prepare, *token); !begun)
        return ended_by(texts, begun.error());
    if (run.work()) return ExitCode::ok;
    if (options.on_leave) options.on_leave();
    leave_program(texts.language(), ExitCode::ok);
}

}  // namespace takt::app
