// Being the devices of a project on its lines, its servers, or one blank device.
#include "commands/serve_command.hpp"

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "commands/input_files.hpp"
#include "log.hpp"
#include "output.hpp"
#include "takt/console/control_server.hpp"
#include "takt/console/fault_commands.hpp"
#include "takt/console/notices.hpp"
#include "takt/endpoint/endpoint_set.hpp"
#include "takt/endpoint/local_values.hpp"
#include "takt/line/descriptors.hpp"
#include "takt/report/serve_report.hpp"
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
        TAKT_CHECK(work_loop_.begin(options_.traffic, [this, has_rules] {
            if (has_rules) return reload_rules();
            print_status(texts_("app.serve.no_rules") + '\n');
        }));
        auto& loop = work_loop_.loop();
        TAKT_TRY(auto faults, begin_faults(loop));
        if (project_) values_.emplace(*project_);
        endpoints_.emplace(
            std::move(specs),
            endpoint::Environment{
                .loop = loop,
                .notify = [this](const auto& notice) { console::put_notice(texts_, messages(), notice); },
                .serve_log = log("serve"),
                .source_log = log("source"),
                .traffic = console::traffic_factory(work_loop_.traffic(), console::LineTraffic::Side::slave),
                .faults = std::move(faults),
                .served = {.project = project_, .values = values_ ? &*values_ : nullptr}});
        return endpoints_->open();
    }

    void work() {
        work_loop_.work(options_.run_for);
        const auto statistics = endpoints_->close();
        if (options_.json)
            print(report::served_json(statistics));
        else
            print_status(report::served_text(texts_, statistics));
    }

private:
    // If the file cannot be used, the old rules stay in force.
    void reload_rules() {
        if (options_.access.empty())
            return reload_access(texts_, options_.file, [this](const model::Project& project) {
                return endpoints_->set_access(project);
            });
        if (const auto rules = load_access(texts_, options_.access)) return endpoints_->set_access(*rules);
        print_error(texts_("app.access.kept", {{"file", options_.access}}));
    }

    /// nullptr: answers are never spoilt.
    Result<std::shared_ptr<sim::AnswerFaults>> begin_faults(line::Loop& loop) {
        if (options_.faults.empty() && options_.control_path.empty()) return nullptr;
        auto faults = std::make_shared<sim::AnswerFaults>();
        for (const auto& rule : options_.faults)
            if (!faults->add(line::now(), rule)) return fail(Code::queue_full, sim::AnswerFaults::kMost);
        if (!options_.control_path.empty()) {
            TAKT_TRY(control_,
                     console::ControlServer::listen(
                         loop, options_.control_path,
                         console::fault_commands(faults, line::now, [&loop] { loop.stop(); }), texts_));
        }
        return faults;
    }

    Texts texts_;
    const ServeOptions& options_;
    const model::Project* project_;
    WorkLoop work_loop_;
    std::unique_ptr<console::ControlServer> control_;
    std::optional<endpoint::LocalValues> values_;
    std::optional<endpoint::EndpointSet> endpoints_;
};

/// The error in the combination of options; nothing: they may be used.
std::optional<std::string> misuse(const Texts& texts, const ServeOptions& options,
                                  const model::Project* project) {
    if (options.state.empty() != options.blank.retain.empty()) return texts("app.registers.where");
    const bool replaced = !options.listen.empty() || !options.port.empty();
    if (!project) return replaced ? std::nullopt : std::optional(texts("app.serve_where"));
    if (!replaced) return std::nullopt;
    if (!project->servers.empty()) return texts("app.serve_has_servers", {{"file", options.file}});
    if (project->lines.size() == 1 && (options.listen.empty() || options.port.empty())) return std::nullopt;
    return texts("app.serve_one_line", {{"count", std::to_string(project->lines.size())}});
}

Result<Specs> specs_of(const ServeOptions& options, const model::Project* project,
                       const endpoint::Overrides& overrides) {
    if (!project) {
        TAKT_TRY(auto blank,
                 endpoint::blank_endpoint(options.blank, options.state,
                                          endpoint::to_durability(options.durability), overrides));
        return Specs{std::move(blank)};
    }
    if (project->servers.empty()) return endpoint::device_endpoints(*project, overrides);
    return endpoint::server_endpoints(*project, options.file, overrides, false);
}

}  // namespace

ExitCode serve(const CommonOptions& common, const ServeOptions& options) {
    const Texts texts(common.language);
    std::optional<host::LoadedProject> loaded;
    if (!options.file.empty() && options.state.empty() == options.blank.retain.empty()) {
        loaded = load_to_run(texts, options.file);
        if (!loaded) return ExitCode::usage;
    }
    const model::Project* const project = loaded ? &loaded->project : nullptr;
    if (const auto wrong = misuse(texts, options, project)) {
        print_error(*wrong);
        return ExitCode::usage;
    }
    endpoint::Overrides overrides{options.listen, options.port, options.strict,
                                  options.limits, {},           options.audit};
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
