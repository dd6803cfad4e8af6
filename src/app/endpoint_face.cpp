#include "endpoint_face.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <memory>
#include <utility>

#include "takt/app/console.hpp"
#include "takt/app/project.hpp"
#include "takt/file/json.hpp"
#include "takt/file/load.hpp"
#include "takt/report/event_report.hpp"

namespace takt::app {
namespace {

/// Notices that are no warnings.
bool is_status(const endpoint::Notice& notice) {
    return notice.code == "app.serving" || notice.code == "app.access.in_force" ||
           notice.code == "app.registers.new";
}

using Named = std::pair<const char*, std::uint64_t>;

std::array<Named, 9> named(const relay::GatewayCounters& counters) {
    return {Named{"asked", counters.asked},    {"sent", counters.sent},
            {"shared", counters.shared},       {"cached", counters.from_cache},
            {"no_answer", counters.no_answer}, {"no_path", counters.no_path},
            {"busy", counters.busy},           {"refused", counters.refused},
            {"forgotten", counters.forgotten}};
}

}  // namespace

void print_notice(const Texts& texts, const endpoint::Notice& notice) {
    const std::string text = report::notice_text(texts, notice);
    if (is_status(notice))
        print_status(text + '\n');
    else
        print_error(text);
}

endpoint::NoticeSink print_notices(const Texts& texts) {
    return [texts](const endpoint::Notice& notice) { print_notice(texts, notice); };
}

std::optional<std::vector<model::AccessRule>> load_access(const Texts& texts, const std::string& path) {
    auto read = file::load_project(path);
    LoadedProject found;
    found.readable = read.readable;
    found.files = read.document.files;
    found.findings = std::move(read.findings);
    std::vector<model::AccessRule> rules;
    if (read.readable) {
        auto checked = model::interpret_access(read.document);
        rules = std::move(checked.rules);
        std::ranges::move(checked.findings, std::back_inserter(found.findings));
    }
    print_status(findings_text(texts, found));
    if (found.has_errors()) return std::nullopt;
    return rules;
}

void reload_access(const Texts& texts, endpoint::EndpointSet& endpoints, const std::string& access_file,
                   const std::string& project_file) {
    if (!access_file.empty()) {
        if (const auto rules = load_access(texts, access_file)) return endpoints.set_access(*rules);
        return print_error(texts("app.access.kept", {{"file", access_file}}));
    }
    const auto loaded = load_project(project_file);
    if (!loaded.has_errors() && endpoints.set_access(loaded.project)) return;
    print_status(findings_text(texts, loaded));
    print_error(texts("app.access.kept", {{"file", project_file}}));
}

report::ServeSummary summary_of(const endpoint::Statistics& statistics) {
    report::ServeSummary summary;
    for (const auto& [where, counters, connections] : statistics.listeners) {
        auto& listener = summary.endpoints.emplace_back();
        listener.where = where;
        listener.counters = counters;
        if (!connections) continue;
        listener.connections = {.accepted = connections->counters.accepted,
                                .refused = connections->counters.refused,
                                .over_limit = connections->counters.over_limit,
                                .over_peer_limit = connections->counters.over_peer_limit,
                                .no_descriptors = connections->counters.no_descriptors,
                                .evicted = connections->counters.evicted,
                                .bad_headers = connections->bad_headers,
                                .frame_deadlines = connections->frame_deadlines,
                                .idle_deadlines = connections->idle_deadlines,
                                .write_stalls = connections->counters.write_stalls};
    }
    for (const auto& [unit, file, written] : statistics.retained)
        summary.retained.push_back({unit, file, written.commits, written.bytes, written.failures});
    return summary;
}

std::string relayed_text(const Texts& texts, const model::Project& project,
                         const endpoint::Statistics& statistics) {
    std::string text;
    for (const auto& [line, counters] : statistics.relayed) {
        Texts::Arguments arguments{{"line", project.lines[line].name}};
        for (const auto& [name, count] : named(counters)) arguments.emplace_back(name, std::to_string(count));
        text += texts("app.relayed", arguments) + '\n';
    }
    return text;
}

std::string relayed_json(const model::Project& project, const endpoint::Statistics& statistics) {
    std::string text;
    for (const auto& [line, counters] : statistics.relayed) {
        auto object = file::Json::object();
        object.set("event", "relayed");
        object.set("line", project.lines[line].name);
        for (const auto& [name, count] : named(counters)) object.set(name, count);
        text += object.dump() + '\n';
    }
    return text;
}

}  // namespace takt::app
