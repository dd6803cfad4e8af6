// Being the devices of a project on its lines, its servers, or one blank device.
#include "commands.hpp"

#include <unistd.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "log.hpp"
#include "offline/input_files.hpp"
#include "output.hpp"
#include "stop_signals.hpp"
#include "takt/console/capture_log.hpp"
#include "takt/console/control_server.hpp"
#include "takt/console/fault_commands.hpp"
#include "takt/console/input_commands.hpp"
#include "takt/console/notices.hpp"
#include "takt/endpoint/endpoint_set.hpp"
#include "takt/endpoint/local_values.hpp"
#include "takt/line/descriptors.hpp"
#include "takt/line/target.hpp"
#include "takt/report/states/serve_report.hpp"
#include "takt/sim/devices.hpp"
#include "texts.hpp"
#include "work_loop.hpp"

namespace takt::app {
namespace {

using Specs = std::vector<endpoint::EndpointSpec>;

/// Everything of a serving, in the order in which it must be made and (backwards) taken down.
class Service {
public:
    /// @param project  nullptr: none; options and project outlive it
    Service(const Texts& texts, const ServeOptions& options, const model::Project* project)
        : texts_(texts), options_(options), project_(project) {}

    Result<void> begin(Specs specs) {
        (void)line::raise_descriptor_limit();
        const bool has_rules = !options_.access.empty() || endpoint::has_access_rules(specs);
        TAKT_CHECK(work_loop_.begin(
            options_.traffic,
            [this, has_rules] {
                if (has_rules) return reload_rules();
                print_status(texts_("app.serve.no_rules") + '\n');
            },
            texts_));
        TAKT_CHECK(begin_taps());
        auto& loop = work_loop_.loop();
        const auto devices = std::make_shared<console::ServedDevices>();
        TAKT_TRY(auto faults, begin_faults(loop, devices));
        if (project_) values_.emplace(*project_);
        endpoints_.emplace(
            std::move(specs),
            endpoint::Environment{
                .loop = loop,
                .notify = [this](const auto& notice) { console::put_notice(texts_, messages(), notice); },
                .serve_log = log("serve"),
                .source_log = log("source"),
                .traffic = tap_ ? tap_->factory() : line::TrafficFactory(),
                .faults = std::move(faults),
                .served = {.project = project_, .values = values_ ? &*values_ : nullptr}});
        add_devices(*devices);
        return endpoints_->open();
    }

    void work() {
        const auto steps = begin_realtime(options_.realtime, work_loop_.loop());
        print_realtime(texts_, options_.realtime, steps, false);
        work_loop_.work(options_.run_for);
        const auto statistics = endpoints_->close();
        logger_.reset();
        capture_.reset();
        if (options_.json)
            print(report::served_json(statistics));
        else
            print_status(report::served_text(texts_, statistics));
    }

private:
    /// The loop never waits for a disk, a terminal or another thread: the frames go through a ring.
    Result<void> begin_taps() {
        if (!work_loop_.traffic() && options_.capture.path.empty()) return {};
        tap_.emplace();
        if (auto* const log = work_loop_.traffic()) logger_.emplace(*log, console::tap_source(*tap_));
        if (options_.capture.path.empty()) return {};
        TAKT_TRY(auto file, console::CaptureFile::open(options_.capture));
        capture_.emplace(std::move(file), console::tap_source(*tap_), file_reports(texts_));
        return {};
    }

    // If the file cannot be used, the old rules stay in force.
    void reload_rules() {
        if (options_.access.empty())
            return reload_access(texts_, options_.file, [this](const model::Project& project) {
                return endpoints_->set_access(project);
            });
        if (const auto rules = load_access(texts_, options_.access)) return endpoints_->set_access(*rules);
        print_error(texts_("app.access.kept", {{"file", options_.access}}));
    }

    void add_devices(console::ServedDevices& devices) {
        for (std::size_t i = 0; i < endpoints_->size(); ++i) {
            auto& endpoint = (*endpoints_)[i];
            auto* const simulated = endpoint.devices();
            if (simulated == nullptr) continue;
            const auto& line = std::get<endpoint::LineDevices>(endpoint.spec().units).line;
            for (std::size_t device = 0; device < simulated->size(); ++device)
                devices.add(line, device, (*simulated)[device]);
        }
    }

    /// nullptr: answers are never spoilt.
    Result<std::shared_ptr<sim::AnswerFaults>> begin_faults(
        line::Loop& loop, const std::shared_ptr<console::ServedDevices>& devices) {
        const bool commands = !options_.control_path.empty() || options_.commands_from_stdin;
        if (options_.faults.empty() && !commands) return nullptr;
        auto faults = std::make_shared<sim::AnswerFaults>();
        for (const auto& rule : options_.faults)
            if (!faults->add(line::now(), rule)) return fail(Code::queue_full, sim::AnswerFaults::kMost);
        const auto execute = console::fault_commands(faults, devices, line::now, [&loop] { loop.stop(); });
        if (!options_.control_path.empty()) {
            TAKT_TRY(control_, console::ControlServer::listen(loop, options_.control_path, execute, texts_));
        }
        if (options_.commands_from_stdin)
            input_.emplace(loop, STDIN_FILENO, execute, texts_,
                           [this](const console::Answer& answer) { print_answer(answer); });
        return faults;
    }

    void print_answer(const console::Answer& answer) const {
        if (!options_.json) return print(answer.line);
        auto object = answer.json;
        if (object == file::Json()) {
            object = file::Json::object();
            object.set("event", "answer");
            object.set("text", answer.line.substr(0, answer.line.find_last_not_of('\n') + 1));
        }
        print(object.dump() + '\n');
    }

    Texts texts_;
    const ServeOptions& options_;
    const model::Project* project_;
    WorkLoop work_loop_;
    std::optional<host::TrafficTap> tap_;
    std::optional<console::TapLogger> logger_;
    std::optional<console::CaptureLog> capture_;
    std::unique_ptr<console::ControlServer> control_;
    std::optional<console::InputCommands> input_;
    std::optional<endpoint::LocalValues> values_;
    std::optional<endpoint::EndpointSet> endpoints_;
};

/// --port with a target that is no serial port.
bool is_no_serial_port(const std::string& port) {
    const auto target = line::parse_target(port);
    return target && target->transport != model::Transport::serial;
}

/// The error of a project whose lines have no address of their own; nothing: each has one.
std::optional<std::string> without_address(const Texts& texts, const ServeOptions& options,
                                           const host::LoadedProject& loaded) {
    const auto& lines = loaded.project.lines;
    const auto simulated = std::ranges::find(lines, model::Transport::simulated, &model::Line::transport);
    if (simulated == lines.end()) return std::nullopt;
    const bool chosen = lines.size() > 1 || !options.line.empty();
    return texts("app.serve.simulated",
                 {{"file", loaded.files[simulated->location.file]},
                  {"row", std::to_string(simulated->location.line)},
                  {"line", simulated->name},
                  {"command", "takt serve " + options.file + (chosen ? " --line " + simulated->name : "")}});
}

/// The error in the combination of options; nothing: they may be used.
std::optional<std::string> misuse(const Texts& texts, const ServeOptions& options,
                                  const std::optional<host::LoadedProject>& loaded) {
    const bool replaced = !options.listen.empty() || !options.port.empty();
    if (is_no_serial_port(options.port)) return texts("app.serve.no_serial_port", {{"value", options.port}});
    if (!loaded) return replaced ? std::nullopt : std::optional(texts("app.serve_where"));
    const auto& project = loaded->project;
    if (options.fill != sim::Fill::zero && project.servers.empty())
        return texts("app.serve.fill_of_lines", {{"file", options.file}});
    if (!replaced) return project.servers.empty() ? without_address(texts, options, *loaded) : std::nullopt;
    if (!project.servers.empty()) return texts("app.serve_has_servers", {{"file", options.file}});
    if (project.lines.size() == 1 && (options.listen.empty() || options.port.empty())) return std::nullopt;
    return texts("app.serve_one_line", {{"count", std::to_string(project.lines.size())}});
}

/// Leaves the devices of the line that the options name. @returns false, and reports it, if there is none
bool keep_line(const Texts& texts, const ServeOptions& options, model::Project& project) {
    if (!project.servers.empty()) {
        print_error(texts("app.serve.line_of_servers", {{"file", options.file}}));
        return false;
    }
    std::string names;
    for (const auto& line : project.lines) names += (names.empty() ? "" : ", ") + line.name;
    std::erase_if(project.lines, [&](const model::Line& line) { return line.name != options.line; });
    if (!project.lines.empty()) return true;
    print_error(
        texts("app.serve.no_line", {{"name", options.line}, {"file", options.file}, {"names", names}}));
    return false;
}

Result<Specs> specs_of(const ServeOptions& options, const model::Project* project,
                       const endpoint::Overrides& overrides) {
    if (!project) {
        TAKT_TRY(auto blank, endpoint::blank_endpoint(options.unit, overrides));
        return Specs{std::move(blank)};
    }
    if (project->servers.empty()) return endpoint::device_endpoints(*project, overrides);
    return endpoint::server_endpoints(*project, options.file, overrides, false);
}

}  // namespace

ExitCode serve(const CommonOptions& common, const ServeOptions& options) {
    hold_reload();
    const Texts texts(common.language);
    std::optional<host::LoadedProject> loaded;
    if (!options.file.empty()) {
        loaded = load_to_run(texts, options.file);
        if (!loaded) return ExitCode::usage;
    }
    if (loaded && !options.line.empty() && !keep_line(texts, options, loaded->project))
        return ExitCode::usage;
    if (const auto wrong = misuse(texts, options, loaded)) return ended_with(*wrong, ExitCode::usage);
    const model::Project* const project = loaded ? &loaded->project : nullptr;
    endpoint::Overrides overrides{options.listen, options.port, options.strict, options.limits, {},
                                  options.audit,  options.fill};
    if (!options.access.empty()) {
        overrides.access = load_access(texts, options.access);
        if (!overrides.access) return ExitCode::usage;
    }
    auto specs = specs_of(options, project, overrides);
    if (!specs) return ended_by(texts, specs.error());
    const bool servers = project && !project->servers.empty();
    if (const auto count = servers ? endpoint::bound_to_lines(*project) : 0; count > 0)
        print_status(texts("app.serve.not_polled", {{"count", std::to_string(count)}}) + '\n');
    Service service(texts, options, servers ? project : nullptr);
    if (const auto begun = service.begin(*std::move(specs)); !begun) return ended_by(texts, begun.error());
    service.work();
    return ExitCode::ok;
}

}  // namespace takt::app
