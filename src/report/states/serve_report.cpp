// The text leaves out refused and ended connections where there were none. The JSON has every counter, zeros
// too, so that its keys do not depend on what happened (docs/commands/serve.md).
#include "takt/report/states/serve_report.hpp"

#include <array>
#include <utility>
#include <vector>

#include "takt/file/json.hpp"

namespace takt::report {
namespace {

using file::Json;

std::uint64_t dropped_requests(const serve::Counters& counters) {
    std::uint64_t all = 0;
    for (const std::uint64_t count : counters.faults) all += count;
    return all;
}

using Connections = endpoint::ListenerStatistics::Connections;

std::string connections_text(const Texts& texts, const std::string& where, const Connections& connections) {
    const auto& counts = connections.counters;
    std::string text =
        texts("app.served_connections", {{"where", where}, {"accepted", std::to_string(counts.accepted)}}) +
        '\n';
    if (counts.refused > 0)
        text += texts("app.served_refused", {{"where", where},
                                             {"count", std::to_string(counts.refused)},
                                             {"limit", std::to_string(counts.over_limit)},
                                             {"peer", std::to_string(counts.over_peer_limit)},
                                             {"descriptors", std::to_string(counts.no_descriptors)},
                                             {"tls", std::to_string(counts.no_tls)}}) +
                '\n';
    const std::uint64_t ended = connections.bad_headers + connections.frame_deadlines +
                                connections.idle_deadlines + counts.write_stalls + counts.evicted;
    if (ended > 0)
        text += texts("app.served_ended", {{"where", where},
                                           {"count", std::to_string(ended)},
                                           {"header", std::to_string(connections.bad_headers)},
                                           {"frame", std::to_string(connections.frame_deadlines)},
                                           {"idle", std::to_string(connections.idle_deadlines)},
                                           {"unread", std::to_string(counts.write_stalls)},
                                           {"evicted", std::to_string(counts.evicted)}}) +
                '\n';
    return text;
}

Json connections_json(const Connections& connections) {
    const auto& counts = connections.counters;
    auto refused = Json::object();
    refused.set("connections", counts.over_limit);
    refused.set("connections_per_peer", counts.over_peer_limit);
    refused.set("descriptors", counts.no_descriptors);
    refused.set("tls", counts.no_tls);
    auto ended = Json::object();
    ended.set("bad_header", connections.bad_headers);
    ended.set("frame_timeout", connections.frame_deadlines);
    ended.set("idle_timeout", connections.idle_deadlines);
    ended.set("unread", counts.write_stalls);
    ended.set("evicted", counts.evicted);
    auto object = Json::object();
    object.set("accepted", counts.accepted);
    object.set("refused", std::move(refused));
    object.set("ended", std::move(ended));
    return object;
}

Json listener_json(const endpoint::ListenerStatistics& listener) {
    const auto& counters = listener.counters;
    auto dropped = Json::object();
    for (std::size_t i = 1; i < counters.faults.size(); ++i)
        dropped.set(wire::name(wire::FrameFault{static_cast<std::uint8_t>(i)}), counters.faults[i]);
    auto object = Json::object();
    object.set("where", listener.where);
    object.set("requests", counters.requests);
    object.set("broadcasts", counters.broadcasts);
    object.set("answers", counters.answers);
    object.set("exceptions", counters.exceptions);
    object.set("unanswered", counters.unanswered);
    object.set("other_units", counters.other_units);
    object.set("dropped", std::move(dropped));
    if (listener.connections) object.set("connections", connections_json(*listener.connections));
    return object;
}

Json retained_json(const std::vector<endpoint::RetainedStatistics>& units) {
    auto list = Json::array();
    for (const auto& [unit, file, written] : units) {
        auto object = Json::object();
        object.set("unit", std::uint64_t{unit.value});
        object.set("file", file);
        object.set("commits", written.commits);
        object.set("bytes", written.bytes);
        object.set("failures", written.failures);
        list.push_back(std::move(object));
    }
    return list;
}

using Instrument = endpoint::InstrumentStatistics;
using NamedCount = std::pair<const char*, std::uint64_t>;

std::array<NamedCount, 12> instrument_counts(const endpoint::InstrumentCounters& counters) {
    return {{{"requests", counters.requests},
             {"answers", counters.answers},
             {"timeouts", counters.timeouts},
             {"other", counters.strange},
             {"resets", counters.resets},
             {"starts", counters.starts},
             {"failed_starts", counters.failed_starts},
             {"written", counters.written},
             {"refused", counters.refused},
             {"unanswered", counters.unanswered},
             {"busy", counters.busy},
             {"restored", counters.restored}}};
}

std::string instrument_text(const Texts& texts, const Instrument& instrument) {
    Texts::Arguments arguments{
        {"instrument", instrument.name},
        {"state", texts("instrument.state." + std::string(endpoint::name(instrument.state)))}};
    for (const auto& [name, count] : instrument_counts(instrument.counters))
        arguments.emplace_back(name, std::to_string(count));
    const auto& counters = instrument.counters;
    std::string text = texts("app.instrument", arguments) + '\n';
    if (counters.starts + counters.failed_starts + counters.resets > 0)
        text += texts("app.instrument_starts", arguments) + '\n';
    if (counters.written + counters.refused + counters.unanswered + counters.busy > 0)
        text += texts("app.instrument_commands", arguments) + '\n';
    return text;
}

Json instruments_json(const std::vector<Instrument>& instruments) {
    auto list = Json::array();
    for (const auto& instrument : instruments) {
        auto object = Json::object();
        object.set("name", instrument.name);
        object.set("state", endpoint::name(instrument.state));
        for (const auto& [name, count] : instrument_counts(instrument.counters)) object.set(name, count);
        list.push_back(std::move(object));
    }
    return list;
}

std::array<NamedCount, 10> gateway_counts(const serve::GatewayCounters& counters) {
    return {NamedCount{"asked", counters.asked}, {"sent", counters.sent},
            {"shared", counters.shared},         {"cached", counters.from_cache},
            {"no_answer", counters.no_answer},   {"not_asked", counters.not_asked},
            {"no_path", counters.no_path},       {"busy", counters.busy},
            {"refused", counters.refused},       {"forgotten", counters.forgotten}};
}

}  // namespace

std::string served_text(const Texts& texts, const endpoint::Statistics& statistics) {
    std::string text;
    for (const auto& [where, counters, connections] : statistics.listeners) {
        text += texts("app.served", {{"where", where},
                                     {"requests", std::to_string(counters.requests)},
                                     {"answers", std::to_string(counters.answers)},
                                     {"exceptions", std::to_string(counters.exceptions)},
                                     {"dropped", std::to_string(dropped_requests(counters))}}) +
                '\n';
        if (connections) text += connections_text(texts, where, *connections);
    }
    for (const auto& [unit, file, written] : statistics.retained)
        text += texts("app.served_registers", {{"unit", std::to_string(unit.value)},
                                               {"file", file},
                                               {"commits", std::to_string(written.commits)},
                                               {"bytes", std::to_string(written.bytes)},
                                               {"failures", std::to_string(written.failures)}}) +
                '\n';
    for (const auto& instrument : statistics.instruments) text += instrument_text(texts, instrument);
    return text;
}

std::string served_json(const endpoint::Statistics& statistics, std::string_view event) {
    auto list = Json::array();
    for (const auto& listener : statistics.listeners) list.push_back(listener_json(listener));
    auto object = Json::object();
    if (!event.empty()) object.set("event", event);
    object.set("served", std::move(list));
    if (!statistics.retained.empty()) object.set("retained", retained_json(statistics.retained));
    if (!statistics.instruments.empty()) object.set("instruments", instruments_json(statistics.instruments));
    return object.dump() + '\n';
}

std::string relayed_text(const Texts& texts, const model::Project& project,
                         const endpoint::Statistics& statistics) {
    std::string text;
    for (const auto& [line, counters] : statistics.relayed) {
        Texts::Arguments arguments{{"line", project.lines[line].name}};
        for (const auto& [name, count] : gateway_counts(counters))
            arguments.emplace_back(name, std::to_string(count));
        text += texts("app.relayed", arguments) + '\n';
    }
    return text;
}

std::string relayed_json(const model::Project& project, const endpoint::Statistics& statistics) {
    std::string text;
    for (const auto& [line, counters] : statistics.relayed) {
        auto object = Json::object();
        object.set("event", "relayed");
        object.set("line", project.lines[line].name);
        for (const auto& [name, count] : gateway_counts(counters)) object.set(name, count);
        text += object.dump() + '\n';
    }
    return text;
}

}  // namespace takt::report
