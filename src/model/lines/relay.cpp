// Key `relay` of a server: the units that it passes on to lines.
#include <algorithm>
#include <set>

#include "servers/interpretation.hpp"
#include "takt/model/nearest.hpp"

namespace takt::model {
namespace {

constexpr ItemRange kAllUnits{1, 247};
constexpr std::uint16_t kLastUnit = 255;
constexpr std::size_t kLinesToCompare = 1000;

std::optional<std::size_t> find_line(const Interpretation& state, Reader& reader) {
    const auto wanted = reader.text("line");
    if (!wanted) return std::nullopt;
    const auto& lines = state.project.lines;
    const auto found = std::ranges::find(lines, *wanted, &Line::name);
    if (found != lines.end()) return static_cast<std::size_t>(found - lines.begin());
    std::vector<std::string_view> names;
    for (const auto& line : lines)
        if (!line.name.empty() && names.size() < kLinesToCompare) names.emplace_back(line.name);
    if (names.empty())
        reader.report(Rule::name_none, "line", {}, {{"kind", "line"}});
    else
        reader.report(Rule::line_unknown, "line", {}, {{"nearest", std::string(nearest(*wanted, names))}});
    return std::nullopt;
}

void read_map(Interpretation& state, Reader& reader, Relay& relay) {
    const Node* const list = reader.list("map");
    if (list == nullptr) return;
    std::set<std::int64_t> taken;
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        const auto path = reader.path_of("map") + "[" + std::to_string(i) + "]";
        if (!is_mapping(state, item, path)) continue;
        Reader entry(state.findings, item, path, Object::relay_map, state.context);
        const auto from = entry.integer("from");
        const auto to = entry.integer("to");
        if (from && !taken.insert(*from).second)
            entry.report(Rule::number_twice, "from", {}, {{"key", "from"}});
        else if (from && to)
            relay.map.push_back(
                {UnitId{static_cast<std::uint8_t>(*from)}, UnitId{static_cast<std::uint8_t>(*to)}});
    }
}

void read_relay_units(Interpretation& state, Reader& reader, Relay& relay) {
    relay.units = read_item_ranges(state, reader, "units");
    if (!relay.units.empty() && relay.units.back().last > kLastUnit) {
        state.findings.add(Rule::field_out_of_range, reader.value("units")->location, reader.path_of("units"),
                           std::to_string(relay.units.back().last), reader.allowed_text("units"));
        relay.units.clear();
    }
    read_map(state, reader, relay);
    if (!reader.given("units") && !reader.given("map")) relay.units = {kAllUnits};
}

void share(Line& line, const Relay& relay) {
    if (!line.relayed) line.relayed.emplace();
    line.relayed->response_timeout = std::max(line.relayed->response_timeout, relay.response_timeout);
    const bool has_0 = !relay.units.empty() && relay.units.front().first == kBroadcast.value;
    if (has_0 || std::ranges::count(relay.map, kBroadcast, &UnitMapping::to) > 0)
        line.relayed->broadcast = true;
}

}  // namespace

void interpret_relays(Interpretation& state, Reader& server, std::vector<Relay>& relays) {
    const Node* const list = server.list("relay");
    if (list == nullptr) return;
    if (list->items.empty()) server.report(Rule::field_empty, "relay", {}, {{"key", "relay"}});
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        const auto path = server.path_of("relay") + "[" + std::to_string(i) + "]";
        if (!is_mapping(state, item, path)) continue;
        Reader reader(state.findings, item, path, Object::relay, state.context);
        Relay relay;
        relay.location = item.location;
        const auto line = find_line(state, reader);
        read_relay_units(state, reader, relay);
        relay.cache = reader.duration("cache").value_or(relay.cache);
        relay.attempts = static_cast<std::uint16_t>(reader.integer("attempts").value_or(relay.attempts));
        relay.response_timeout = reader.duration("response_timeout").value_or(relay.response_timeout);
        relay.max_wait = reader.duration("max_wait").value_or(relay.max_wait);
        if (!line) continue;
        relay.line = *line;
        share(state.project.lines[*line], relay);
        relays.push_back(std::move(relay));
    }
}

void check_lines_without_devices(Interpretation& state) {
    for (const auto& [line, rule, location, path] : state.without_devices) {
        if (state.project.lines[line].relayed) continue;
        state.findings.add(rule, location, path, {}, {}, {{"key", "devices"}});
    }
}

}  // namespace takt::model
