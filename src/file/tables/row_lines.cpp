#include "tables/row_lines.hpp"

#include <algorithm>
#include <utility>

#include "takt/file/table.hpp"
#include "yaml/nodes.hpp"

namespace takt::file {
namespace {

using model::Node;

constexpr std::string_view kTargets = "tcp://HOST, rtu+tcp://HOST, rtu:///dev/ttyUSB0?baud=9600";

}  // namespace

void Disagreements::report(const Node& cell, std::string_view key, const std::string& first) {
    if (!reported_.emplace(key).second) return;
    reporter_.error("file.convert.two_values", cell.location,
                    {.value = cell.text, .arguments = {{"key", std::string(key)}, {"first", first}}});
}

RowLines::RowLines(const Surroundings& surroundings, Reporter& reporter, Disagreements& disagreements)
    : surroundings_(surroundings), reporter_(reporter), disagreements_(disagreements), lines_(1) {
    lines_.front().settings = mapping_of(surroundings.line);
}

std::string RowLines::name(std::size_t line) const {
    return text_of(lines_[line].settings, "name");
}

std::size_t RowLines::of(const Node& row) {
    const auto* const name = row.find(kLineColumn);
    const auto* const target = row.find(kTargetColumn);
    const auto is_it = [&](const Line& line) {
        return name == nullptr || (line.named && text_of(line.settings, "name") == name->text);
    };
    auto found = std::ranges::find_if(lines_, is_it);
    if (found == lines_.end()) {
        const bool first = !lines_.front().named;
        if (!first && target == nullptr)
            reporter_.error("file.convert.several_lines", name->location,
                            {.value = name->text, .arguments = {{"first", this->name(0)}}});
        if (!first) lines_.emplace_back().settings = mapping_of(surroundings_.line);
        found = first ? lines_.begin() : std::prev(lines_.end());
        set(found->settings, "name", *name);
        found->named = true;
    }
    if (target != nullptr) take_target(*found, *target);
    return static_cast<std::size_t>(found - lines_.begin());
}

void RowLines::take_target(Line& line, const Node& cell) {
    if (line.target == cell.text) return;
    if (!line.target.empty()) return disagreements_.report(cell, kTargetColumn, line.target);
    line.target = cell.text;
    const auto known = surroundings_.connections.find(cell.text);
    if (known == surroundings_.connections.end()) {
        reporter_.error("file.convert.target", cell.location,
                        {.value = cell.text, .allowed = std::string(kTargets)});
        return set(line.settings, "port", cell);  // no further finding about the port of another line
    }
    const auto name = *line.settings.find("name");
    line.settings = mapping_of({{"name", ""}}, cell.location);
    set(line.settings, "name", name);
    for (const auto& [key, text] : known->second) set(line.settings, key, scalar(text, cell.location));
}

void RowLines::take_protocol(std::size_t index, const Node& cell) {
    Line& line = lines_[index];
    std::string word = cell.text;
    std::ranges::transform(word, word.begin(),
                           [](char c) { return c >= 'A' && c <= 'Z' ? char(c + 32) : c; });
    const std::string framing = word.ends_with("ascii") ? "ascii" : word.ends_with("rtu") ? "rtu" : "";
    if (!line.protocol.empty() && line.protocol != cell.text)
        return disagreements_.report(cell, kProtocolColumn, line.protocol);
    const bool first = line.protocol.empty();
    line.protocol = cell.text;
    if (!first || text_of(line.settings, "framing") == framing) return;
    if (framing.empty() || text_of(line.settings, "transport") != "serial")
        return reporter_.warning("file.convert.protocol_ignored", cell.location,
                                 {.value = cell.text, .allowed = "Modbus RTU, Modbus ASCII"});
    set(line.settings, "framing", scalar(framing, cell.location));
    std::erase_if(line.settings.entries, [](const auto& entry) { return entry.key.text == "data_bits"; });
}

Node RowLines::take(std::vector<Node> devices) {
    auto list = collection(Node::Kind::list);
    for (std::size_t i = 0; i < lines_.size(); ++i) {
        set(lines_[i].settings, "devices", std::move(devices[i]));
        list.items.push_back(std::move(lines_[i].settings));
    }
    return list;
}

}  // namespace takt::file
