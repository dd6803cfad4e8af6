// The text leaves out refused and ended connections where there were none. The JSON has every counter, zeros too, so
// that its keys do not depend on what happened (docs/commands/serve.md).
#include "takt/report/serve_report.hpp"

#include "takt/file/json.hpp"

namespace takt::report {
namespace {

using file::Json;

std::string text_of(std::uint64_t number) {
    return std::to_string(number);
}

std::uint64_t faults(const serve::Counters& counters) {
    std::uint64_t all = 0;
    for (const std::uint64_t count : counters.faults) all += count;
    return all;
}

std::string connections_text(const Texts& texts, const std::string& where, const ConnectionCounts& counts) {
    std::string text =
        texts("app.served_connections", {{"where", where}, {"accepted", text_of(counts.accepted)}}) + '\n';
    if (counts.refused > 0)
        text += texts("app.served_refused", {{"where", where},
                                             {"count", text_of(counts.refused)},
                                             {"limit", text_of(counts.over_limit)},
                                             {"peer", text_of(counts.over_peer_limit)},
                                             {"descriptors", text_of(counts.no_descriptors)}}) +
                '\n';
    const std::uint64_t ended =
        counts.bad_headers + counts.frame_deadlines + counts.idle_deadlines + counts.write_stalls + counts.evicted;
    if (ended > 0)
        text += texts("app.served_ended", {{"where", where},
                                           {"count", text_of(ended)},
                                           {"header", text_of(counts.bad_headers)},
                                           {"frame", text_of(counts.frame_deadlines)},
                                           {"idle", text_of(counts.idle_deadlines)},
                                           {"unread", text_of(counts.write_stalls)},
                                           {"evicted", text_of(counts.evicted)}}) +
                '\n';
    return text;
}

Json connections_json(const ConnectionCounts& counts) {
    auto refused = Json::object();
    refused.set("connections", counts.over_limit);
    refused.set("connections_per_peer", counts.over_peer_limit);
    refused.set("descriptors", counts.no_descriptors);
    auto ended = Json::object();
    ended.set("bad_header", counts.bad_headers);
    ended.set("frame_timeout", counts.frame_deadlines);
    ended.set("idle_timeout", counts.idle_deadlines);
    ended.set("unread", counts.write_stalls);
    ended.set("evicted", counts.evicted);
    auto object = Json::object();
    object.set("accepted", counts.accepted);
    object.set("refused", std::move(refused));
    object.set("ended", std::move(ended));
    return object;
}

Json endpoint_json(const EndpointSummary& endpoint) {
    const auto& counters = endpoint.counters;
    auto dropped = Json::object();
    for (std::size_t i = 1; i < counters.faults.size(); ++i)
        dropped.set(wire::name(wire::FrameFault{static_cast<std::uint8_t>(i)}), counters.faults[i]);
    auto object = Json::object();
    object.set("where", endpoint.where);
    object.set("requests", counters.requests);
    object.set("broadcasts", counters.broadcasts);
    object.set("answers", counters.answers);
    object.set("exceptions", counters.exceptions);
    object.set("unanswered", counters.unanswered);
    object.set("other_units", counters.other_units);
    object.set("dropped", std::move(dropped));
    if (endpoint.connections) object.set("connections", connections_json(*endpoint.connections));
    return object;
}

Json retained_json(const std::vector<RetainedSummary>& units) {
    auto list = Json::array();
    for (const auto& retained : units) {
        auto object = Json::object();
        object.set("unit", std::uint64_t{retained.unit.value});
        object.set("file", retained.file);
        object.set("commits", retained.commits);
        object.set("bytes", retained.bytes);
        object.set("failures", retained.failures);
        list.push_back(std::move(object));
    }
    return list;
}

}  // namespace

std::string served_text(const Texts& texts, const ServeSummary& summary) {
    std::string text;
    for (const auto& endpoint : summary.endpoints) {
        text += texts("app.served", {{"where", endpoint.where},
                                     {"requests", text_of(endpoint.counters.requests)},
                                     {"answers", text_of(endpoint.counters.answers)},
                                     {"exceptions", text_of(endpoint.counters.exceptions)},
                                     {"dropped", text_of(faults(endpoint.counters))}}) +
                '\n';
        if (endpoint.connections) text += connections_text(texts, endpoint.where, *endpoint.connections);
    }
    for (const auto& retained : summary.retained)
        text += texts("app.served_registers", {{"unit", std::to_string(retained.unit.value)},
                                               {"file", retained.file},
                                               {"commits", text_of(retained.commits)},
                                               {"bytes", text_of(retained.bytes)},
                                               {"failures", text_of(retained.failures)}}) +
                '\n';
    return text;
}

std::string served_json(const ServeSummary& summary, std::string_view event) {
    auto list = Json::array();
    for (const auto& endpoint : summary.endpoints) list.push_back(endpoint_json(endpoint));
    auto object = Json::object();
    if (!event.empty()) object.set("event", event);
    object.set("served", std::move(list));
    if (!summary.retained.empty()) object.set("retained", retained_json(summary.retained));
    return object.dump() + '\n';
}

}  // namespace takt::report
