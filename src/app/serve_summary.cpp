#include "takt/app/serve_summary.hpp"

#include "takt/file/json.hpp"

namespace takt::app {
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

std::string listening_text(const Texts& texts, const ServedPlace& place) {
    const auto& listening = *place.listening;
    const auto& connections = listening.connections;
    std::string text = texts("app.served_connections",
                             {{"where", place.where}, {"accepted", text_of(connections.accepted)}}) +
                       '\n';
    if (connections.refused > 0)
        text += texts("app.served_refused", {{"where", place.where},
                                             {"count", text_of(connections.refused)},
                                             {"limit", text_of(connections.over_limit)},
                                             {"peer", text_of(connections.over_peer_limit)},
                                             {"descriptors", text_of(connections.no_descriptors)}}) +
                '\n';
    const std::uint64_t ended = listening.bad_headers + listening.frame_deadlines + listening.idle_deadlines +
                                connections.write_stalls;
    if (ended > 0)
        text += texts("app.served_ended", {{"where", place.where},
                                           {"count", text_of(ended)},
                                           {"header", text_of(listening.bad_headers)},
                                           {"frame", text_of(listening.frame_deadlines)},
                                           {"idle", text_of(listening.idle_deadlines)},
                                           {"unread", text_of(connections.write_stalls)}}) +
                '\n';
    return text;
}

Json listening_json(const ServedPlace::Listening& listening) {
    const auto& connections = listening.connections;
    auto refused = Json::object();
    refused.set("connections", connections.over_limit);
    refused.set("connections_per_peer", connections.over_peer_limit);
    refused.set("descriptors", connections.no_descriptors);
    auto ended = Json::object();
    ended.set("bad_header", listening.bad_headers);
    ended.set("frame_timeout", listening.frame_deadlines);
    ended.set("idle_timeout", listening.idle_deadlines);
    ended.set("unread", connections.write_stalls);
    auto object = Json::object();
    object.set("accepted", connections.accepted);
    object.set("refused", std::move(refused));
    object.set("ended", std::move(ended));
    return object;
}

Json place_json(const ServedPlace& place) {
    const auto& counters = place.counters;
    auto dropped = Json::object();
    for (std::size_t i = 1; i < counters.faults.size(); ++i)
        dropped.set(wire::name(wire::FrameFault{static_cast<std::uint8_t>(i)}), counters.faults[i]);
    auto object = Json::object();
    object.set("where", place.where);
    object.set("requests", counters.requests);
    object.set("broadcasts", counters.broadcasts);
    object.set("answers", counters.answers);
    object.set("exceptions", counters.exceptions);
    object.set("unanswered", counters.unanswered);
    object.set("other_units", counters.other_units);
    object.set("dropped", std::move(dropped));
    if (place.listening) object.set("connections", listening_json(*place.listening));
    return object;
}

Json retained_json(const std::vector<RetainedSummary>& kept) {
    auto list = Json::array();
    for (const auto& [unit, file, written] : kept) {
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

}  // namespace

std::string served_text(const Texts& texts, const ServeSummary& summary) {
    std::string text;
    for (const auto& place : summary.places) {
        text += texts("app.served", {{"where", place.where},
                                     {"requests", text_of(place.counters.requests)},
                                     {"answers", text_of(place.counters.answers)},
                                     {"exceptions", text_of(place.counters.exceptions)},
                                     {"dropped", text_of(faults(place.counters))}}) +
                '\n';
        if (place.listening) text += listening_text(texts, place);
    }
    for (const auto& [unit, file, written] : summary.kept)
        text += texts("app.served_registers", {{"unit", std::to_string(unit.value)},
                                               {"file", file},
                                               {"commits", text_of(written.commits)},
                                               {"bytes", text_of(written.bytes)},
                                               {"failures", text_of(written.failures)}}) +
                '\n';
    return text;
}

std::string served_json(const ServeSummary& summary, std::string_view event) {
    auto list = Json::array();
    for (const auto& place : summary.places) list.push_back(place_json(place));
    auto object = Json::object();
    if (!event.empty()) object.set("event", event);
    object.set("served", std::move(list));
    if (!summary.kept.empty()) object.set("retained", retained_json(summary.kept));
    return object.dump() + '\n';
}

}  // namespace takt::app
