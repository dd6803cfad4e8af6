#include "offline/input_files.hpp"

#include <vector>

#include "log.hpp"
#include "output.hpp"
#include "takt/base/log.hpp"
#include "takt/file/read.hpp"
#include "takt/report/plans/findings_report.hpp"
#include "takt/table/format.hpp"

namespace takt::app {

void log_findings(const std::vector<model::Finding>& findings) {
    const auto to = log("project");
    if (!to.enabled()) return;
    for (const auto& finding : findings) {
        if (finding.severity == model::Severity::note) continue;
        std::vector<LogArgument> arguments{
            {.name = "value", .text = finding.value},
            {.name = "allowed", .text = finding.allowed},
            {.name = "path", .text = finding.path},
        };
        for (const auto& [name, text] : finding.arguments) arguments.push_back({.name = name, .text = text});
        to.message(finding.severity == model::Severity::error ? LogLevel::error : LogLevel::warning,
                   finding.code, arguments);
    }
}

std::optional<host::LoadedProject> load_to_run(const Texts& texts, const std::string& path,
                                               std::string* learnt, const std::string& page_address) {
    auto loaded = host::load_project(path);
    for (auto& finding : loaded.findings)
        for (auto& [name, text] : finding.arguments)
            if (!page_address.empty() && finding.code == "lines.none" && name == "web") text = page_address;
    if (learnt) *learnt = host::recall_learnt(loaded, path);
    print_status(report::findings_text(texts, loaded));
    log_findings(loaded.findings);
    if (loaded.has_errors()) return std::nullopt;
    return loaded;
}

std::optional<std::vector<model::AccessRule>> load_access(const Texts& texts, const std::string& path) {
    auto loaded = host::load_access(path);
    print_status(report::findings_text(texts, loaded));
    if (loaded.has_errors()) return std::nullopt;
    return std::move(loaded.rules);
}

void reload_access(const Texts& texts, const std::string& project_file,
                   const std::function<bool(const model::Project&)>& put_in_force) {
    const auto loaded = host::load_project(project_file);
    if (!loaded.has_errors() && put_in_force(loaded.project)) return;
    print_status(report::findings_text(texts, loaded));
    print_error(texts("app.access.kept", {{"file", project_file}}));
}

std::optional<TableFile> read_table_file(const Texts& texts, const std::string& path) {
    const auto text = file::read_file(path, table::kMaxImage);
    if (!text) {
        print_error(texts.describe(text.error()));
        return std::nullopt;
    }
    TableFile read;
    read.image.assign(text->begin(), text->end());
    read.owen = text->starts_with(table::kOwenMagic);
    return read;
}

}  // namespace takt::app
