#include "takt/console/served.hpp"

#include <array>
#include <utility>

#include "takt/file/json.hpp"
#include "takt/report/event_report.hpp"

namespace takt::console {
namespace {

/// Notices that are no warnings.
bool is_status(const endpoint::Notice& notice) {
    return notice.code == "app.serving" || notice.code == "app.access.in_force" ||
           notice.code == "app.registers.new";
}

using Named = std::pair<const char*, std::uint64_t>;

std::array<Named, 10> named(const relay::GatewayCounters& counters) {
    return {Named{"asked", counters.asked},    {"sent", counters.sent},
            {"shared", counters.shared},       {"cached", counters.from_cache},
            {"no_answer", counters.no_answer}, {"not_asked", counters.not_asked},
            {"no_path", counters.no_path},     {"busy", counters.busy},
            {"refused", counters.refused},     {"forgotten", counters.forgotten}};
}

}  // namespace

void put_notice(const Texts& texts, const Messages& messages, const endpoint::Notice& notice) {
    const std::string text = report::notice_text(texts, notice);
    is_status(notice) ? messages.status(text + '\n') : messages.error(text);
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

}  // namespace takt::console
