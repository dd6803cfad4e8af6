#include "takt/report/scan_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "takt/model/fields.hpp"
#include "takt/model/target_url.hpp"
#include "takt/report/formatting.hpp"
#include "takt/report/text_table.hpp"
#include "takt/wire/words.hpp"

namespace takt::report {
namespace {

using discover::FoundDevice;
using discover::ScanFindings;
using discover::ScanTrouble;

constexpr std::array<const char*, 7> kObjects{"vendor",       "product", "revision",   "url",
                                              "product_name", "model",   "application"};

// What may stand in a line of text: anything else becomes a dot.
std::string printable(const std::string& text, std::size_t most = 80) {
    std::string shown;
    for (const char c : text.substr(0, most)) shown += c >= ' ' && c <= '~' ? c : '.';
    const auto end = shown.find_last_not_of(' ');
    return end == std::string::npos ? std::string() : shown.substr(0, end + 1);
}

// The readable part of an answer to 17: a name, as a rule, among a few bytes.
std::string server_name(const std::vector<std::uint8_t>& data) {
    std::string best;
    std::string current;
    for (const auto byte : data) {
        current = byte >= 0x20 && byte < 0x7F ? current + static_cast<char>(byte) : std::string();
        if (current.size() > best.size()) best = current;
    }
    constexpr std::size_t kLeastName = 3;
    return best.size() < kLeastName ? wire::hex(Bytes(data.data(), data.size())) : printable(best);
}

std::string proof_text(const Texts& texts, const discover::FoundUnit& unit) {
    return unit.exception == 0 ? std::string()
                               : texts("app.scan.exception", {{"code", std::to_string(unit.exception)}});
}

std::string remarks(const Texts& texts, const discover::FoundUnit& unit) {
    std::string text;
    for (const auto& [said, code] :
         {std::pair{unit.doubled, "app.scan.doubled"}, std::pair{unit.garbled, "app.scan.some_garbled"},
          std::pair{unit.late, "app.scan.late"}})
        if (said) text += (text.empty() ? "" : "; ") + texts(code);
    return text;
}

std::string quoted(const std::string& text) {
    std::string made = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') made += '\\';
        made += c;
    }
    return made + '"';
}

file::Json optional_text(const std::string* text) {
    return text ? file::Json(printable(*text, text->size())) : file::Json();
}

file::Json device_json(const FoundDevice& device) {
    const auto& unit = device.unit;
    auto object = file::Json::object();
    object.set("target", url_of(device.line));
    object.set("unit", unit.unit.value);
    object.set("framing", std::string(wire::name(device.line.framing)));
    const bool serial = device.line.transport == model::Transport::serial;
    const auto& format = device.line.format;
    object.set("baud", serial ? file::Json(format.baud) : file::Json());
    object.set("parity",
               serial ? file::Json(model::kParities[static_cast<std::size_t>(format.parity)]) : file::Json());
    object.set("stop_bits", serial ? file::Json(format.stop_bits) : file::Json());
    object.set("function", unit.function);
    object.set("exception", unit.exception == 0 ? file::Json() : file::Json(unit.exception));
    object.set("response_ms", static_cast<double>(unit.response_time / std::chrono::microseconds(1)) / 1e3);
    object.set("late", unit.late);
    object.set("garbled", unit.garbled);
    object.set("doubled", unit.doubled);
    for (std::uint8_t id = 0; id < kObjects.size(); ++id)
        object.set(kObjects[id], optional_text(unit.identity.find(id)));
    const auto& server_id = unit.identity.server_id;
    object.set("server_id", server_id.empty()
                                ? file::Json()
                                : file::Json(wire::hex(Bytes(server_id.data(), server_id.size()))));
    return object;
}

std::string_view kind_name(ScanTrouble::Kind kind) {
    switch (kind) {
        case ScanTrouble::Kind::error: return "error";
        case ScanTrouble::Kind::garbled: return "garbled";
        case ScanTrouble::Kind::busy: return "busy";
        case ScanTrouble::Kind::strangers: return "strangers";
    }
    return "error";
}

// ---- the project

using Group = std::vector<const FoundDevice*>;

std::vector<Group> by_target(const ScanFindings& findings) {
    std::vector<Group> groups;
    for (const auto& device : findings.devices) {
        const auto same = std::ranges::find_if(
            groups, [&](const Group& group) { return url_of(group[0]->line) == url_of(device.line); });
        if (same == groups.end())
            groups.push_back({&device});
        else
            same->push_back(&device);
    }
    return groups;
}

std::string line_settings(const model::Line& target) {
    if (target.transport != model::Transport::serial)
        return fmt::format("    transport: {}\n    host: {}\n    tcp_port: {}\n    framing: {}\n",
                           model::name(target.transport), quoted(target.port), target.tcp_port,
                           wire::name(target.framing));
    const auto& format = target.format;
    auto text = fmt::format(
        "    transport: serial\n    port: {}\n    framing: {}\n    baud: {}\n    parity: {}\n    stop_bits: "
        "{}\n"
        "    data_bits: {}\n",
        quoted(target.port), wire::name(target.framing), format.baud,
        model::kParities[static_cast<std::size_t>(format.parity)], format.stop_bits, format.data_bits);
    if (target.rs485 != model::Rs485::automatic)
        text += fmt::format("    rs485: {}\n", model::kRs485[static_cast<std::size_t>(target.rs485)]);
    return text;
}

// The default of 100 ms, unless the device was seen to take longer than half of it.
std::string time_out(const discover::FoundUnit& unit) {
    const auto ms = unit.response_time / std::chrono::milliseconds(1);
    return ms < 50 ? std::string()
                   : fmt::format("        response_timeout: {}ms\n", std::min<std::int64_t>(3 * ms, 65535));
}

std::string variables(const FoundDevice& device, std::size_t line) {
    struct Area {
        std::uint8_t function;
        const char* name;
        const char* keys;
    };
    static constexpr std::array kAreas{Area{3, "holding", "type: uint16, register: 0, read: 0x03"},
                                       Area{4, "input", "type: uint16, register: 0, read: 0x04"},
                                       Area{1, "coil", "type: bool, coil: 0, read: 0x01"}};
    const auto* const area = std::ranges::find(kAreas, device.unit.function, &Area::function);
    if (device.unit.exception != 0 || area == kAreas.end()) return "        variables: []\n";
    return fmt::format("        variables:\n          - {{name: line{}_unit{}_{}_0, {}}}\n", line,
                       device.unit.unit.value, area->name, area->keys);
}

std::string device_yaml(const FoundDevice& device, std::size_t line) {
    const auto what = identity_text(device.unit.identity);
    return fmt::format("      - name: unit {}\n        address: {}\n", device.unit.unit.value,
                       device.unit.unit.value) +
           (what.empty() ? "" : fmt::format("        comment: {}\n", quoted(what))) + time_out(device.unit) +
           variables(device, line);
}

}  // namespace

std::string identity_text(const discover::UnitIdentity& identity) {
    std::string text;
    constexpr std::array<std::uint8_t, 5> kTold{0, 4, 5, 1, 2};
    for (const auto id : kTold) {
        const auto* const object = identity.find(id);
        const auto shown = object ? printable(*object, 40) : std::string();
        if (!shown.empty() && text.find(shown) == std::string::npos)
            text += (text.empty() ? "" : " ") + shown;
    }
    if (text.empty() && !identity.server_id.empty()) return server_name(identity.server_id);
    return text;
}

std::string device_line(const Texts& texts, const FoundDevice& device) {
    auto line = fmt::format("{} --unit {}  {}", url_of(device.line), device.unit.unit.value,
                            milliseconds_text(device.unit.response_time));
    for (const auto& part :
         {identity_text(device.unit.identity), proof_text(texts, device.unit), remarks(texts, device.unit)})
        if (!part.empty()) line += "  " + part;
    return line;
}

std::string trouble_line(const Texts& texts, const ScanTrouble& trouble) {
    const auto where = url_of(trouble.line);
    switch (trouble.kind) {
        case ScanTrouble::Kind::error: return texts.describe(trouble.error);
        case ScanTrouble::Kind::garbled:
            return texts("app.scan.garbled", {{"target", where}, {"unit", std::to_string(trouble.unit)}});
        case ScanTrouble::Kind::busy: return texts("app.scan.busy", {{"target", where}});
        case ScanTrouble::Kind::strangers: return texts("app.scan.strangers", {{"target", where}});
    }
    return {};
}

file::Json scan_json(const Texts& texts, const ScanFindings& findings) {
    auto devices = file::Json::array();
    for (const auto& device : findings.devices) devices.push_back(device_json(device));
    auto troubles = file::Json::array();
    for (const auto& trouble : findings.troubles) {
        auto entry = file::Json::object();
        entry.set("kind", kind_name(trouble.kind));
        entry.set("target", url_of(trouble.line));
        entry.set("unit",
                  trouble.kind == ScanTrouble::Kind::garbled ? file::Json(trouble.unit) : file::Json());
        entry.set("code", trouble.kind == ScanTrouble::Kind::error ? file::Json(name(trouble.error.code))
                                                                   : file::Json());
        entry.set("text", trouble_line(texts, trouble));
        troubles.push_back(std::move(entry));
    }
    auto object = file::Json::object();
    object.set("devices", std::move(devices));
    object.set("troubles", std::move(troubles));
    object.set("absent_hosts", static_cast<std::uint64_t>(findings.absent_hosts));
    object.set("requests", findings.requests);
    object.set("duration_ms", findings.duration / std::chrono::milliseconds(1));
    object.set("complete", findings.complete);
    return object;
}

std::string scan_project(const Texts& texts, const ScanFindings& findings) {
    auto groups = by_target(findings);
    std::ranges::stable_sort(groups, std::greater(), &Group::size);
    std::string text = fmt::format("# {}\ntakt: 1\nlines:\n", texts("app.scan.project_head"));
    std::string others;
    std::set<std::string> ports;
    std::size_t number = 0;
    for (const auto& group : groups) {
        const auto& target = group[0]->line;
        const bool serial = target.transport == model::Transport::serial;
        if (serial && !ports.insert(target.port).second) {
            for (const auto* device : group) others += "# " + device_line(texts, *device) + '\n';
            continue;
        }
        text += fmt::format("  - name: line {}\n{}    devices:\n", ++number, line_settings(target));
        for (const auto* device : group) text += device_yaml(*device, number);
    }
    if (!others.empty()) text += fmt::format("\n# {}\n{}", texts("app.scan.project_others"), others);
    return text;
}

}  // namespace takt::report
