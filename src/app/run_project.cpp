#include "takt/app/run_project.hpp"

#include <unistd.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <utility>

#include "project_servers.hpp"
#include "takt/app/console.hpp"
#include "takt/app/control_server.hpp"
#include "takt/app/log.hpp"
#include "takt/app/reporter.hpp"
#include "takt/app/running.hpp"
#include "takt/line/descriptors.hpp"
#include "work_loop.hpp"

namespace takt::app {
namespace {

bool learns(const model::Project& project) {
    return std::ranges::any_of(project.lines, [](const model::Line& line) { return plan::learns(line); });
}

bool has_access_rules(const model::Project& project) {
    return std::ranges::any_of(project.servers,
                               [](const model::Server& server) { return !server.access.empty(); });
}

std::string json_gap_line(std::uint64_t missed) {
    return "{\"event\":\"gap\",\"missed\":" + std::to_string(missed) + "}\n";
}
std::string text_gap_line(std::uint64_t missed) {
    return "… " + std::to_string(missed) + "\n";
}

std::unique_ptr<Reporter> make_reporter(const Scene& scene, const Texts& texts, const RunOptions& options,
                                        os::LineWriter& out) {
    if (options.json) return make_json_reporter(scene, texts, out);
    const bool in_place = ::isatty(STDOUT_FILENO) != 0 && !options.commands_from_stdin;
    return in_place ? make_live_reporter(scene, texts, out) : make_line_reporter(scene, texts, out);
}

/// Everything of a run, in the order in which it must be made and (backwards) taken down.
class Run {
public:
    Run(const Texts& texts, const model::Project& project, const plan::Plan& plan, const RunOptions& options)
        : texts_(texts),
          project_(project),
          plan_(plan),
          options_(options),
          out_(STDOUT_FILENO, {.gap_line = options.json ? json_gap_line : text_gap_line}) {}

    Result<void> begin(const Running::Prepare& prepare) {
        std::function<void()> reload;
        if (has_access_rules(project_)) reload = [this] { servers_->reload_access(); };
        TAKT_CHECK(work_loop_.begin(options_.traffic, std::move(reload)));
        auto& loop = work_loop_.loop();
        auto* traffic = work_loop_.traffic();
        Running::Keepers keepers;
        if (!options_.state.empty())
            keepers.retention = Retention::open(loop, texts_, project_, options_.state);
        if (options_.learn && learns(project_))
            keepers.learner = std::make_unique<Learner>(loop, project_, texts_, options_.learnt);
        running_ = std::make_unique<Running>(loop, project_, plan_, texts_, traffic, std::move(keepers));
        reporter_ = make_reporter(running_->scene(), texts_, options_, out_);
        if (!options_.control_path.empty()) {
            TAKT_TRY(control_,
                     ControlServer::listen(loop, options_.control_path, commands_of(*running_), texts_));
        }
        if (!project_.servers.empty()) {
            servers_ =
                std::make_unique<ProjectServers>(loop, project_, options_.file, *running_, traffic, texts_);
            TAKT_CHECK(servers_->open());
        }
        TAKT_CHECK(running_->begin(*reporter_, prepare));
        if (options_.commands_from_stdin)
            stdin_ = std::make_unique<StdinCommands>(
                loop, commands_of(*running_, Running::Hearer::reporter), texts_,
                [this](const Answer& answer) { reporter_->on_answer(line::now(), answer); });
        watch_reader_ = std::make_unique<line::Timer>(loop, [this](Instant t) { stop_without_reader(t); });
        watch_reader_->set(line::now());
        return {};
    }

    void work() {
        work_loop_.work(options_.run_for);
        running_->finish();
        if (servers_) end_servers();
        reporter_->end(line::now());
        // Who pressed Ctrl-C waits for at most a second; a run that came to its end gives a slow reader time.
        out_.finish(work_loop_.loop().stopped() ? std::chrono::milliseconds(500) : std::chrono::seconds(10));
        note_stdout_error(out_.error());
    }

private:
    void end_servers() {
        servers_->finish();
        if (options_.json)
            out_.put_last(servers_->summary_json());
        else
            print_status(servers_->summary_text());
    }

    /// Nobody reads the output any more (`takt run … | head`): there is nothing left to do.
    void stop_without_reader(Instant t) {
        if (out_.closed()) return work_loop_.loop().stop();
        watch_reader_->set(after(t, std::chrono::milliseconds(200)));
    }

    Texts texts_;
    const model::Project& project_;
    const plan::Plan& plan_;
    const RunOptions& options_;
    os::LineWriter out_;
    WorkLoop work_loop_;
    std::unique_ptr<Running> running_;
    std::unique_ptr<ProjectServers> servers_;
    std::unique_ptr<Reporter> reporter_;
    std::unique_ptr<ControlServer> control_;
    std::unique_ptr<StdinCommands> stdin_;
    std::unique_ptr<line::Timer> watch_reader_;
};

// Each line that is not simulated holds one; beside them the program's own: the terminal, logs, the loop, and
// those that speak to it.
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
                     const RunOptions& options, const Running::Prepare& prepare) {
    if (!enough_descriptors(texts, project)) return ExitCode::cannot_open;
    Run run(texts, project, plan, options);
    if (const auto begun = run.begin(prepare); !begun) return ended_by(texts, begun.error());
    run.work();
    return ExitCode::ok;
}

}  // namespace takt::app
