#include "takt/report/states/scan_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "takt/file/convert.hpp"
#include "takt/file/project_nodes.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/target_url.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/progress_text.hpp"
#include "takt/report/drawing/text_table.hpp"
#include "takt/report/states/probe_report.hpp"
#include "takt/wire/frame_words.hpp"

namespace takt::report {
namespace {

using bus::FoundDevice;
using bus::ScanFindings;
using bus::ScanTrouble;

constexpr std::array<const char*, 7> kObjects{"vendor",       "product", "revision",   "url",
                                              "product_name", "model",   "application"};

// Printable ASCII; any other byte becomes a dot, and trailing blanks are removed.
std::string printable(const std::string& text, std::size_t most = 80) {
    std::string shown;
    for (const char c : text.substr(0, most)) shown += c >= ' ' && c <= '~' ? c : '.';
    const auto end = shown.find_last_not_of(' ');
    return end == std::string::npos ? std::string() : shown.substr(0, end + 1);
}

// The longest readable part of a response to function 17 (report server ID): a name, as a rule, among a few
// bytes. Without one, all bytes in hex.
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

std::string proof_text(const Texts& texts, const bus::FoundUnit& unit) {
    return unit.exception == 0 ? std::string()
                               : texts("app.scan.exception", {{"code", std::to_string(unit.exception)}});
}

std::string found_unit_remarks(const Texts& texts, const bus::FoundUnit& unit) {
    std::string text;
    for (const auto& [applies, code] :
         {std::pair{unit.doubled, "app.scan.doubled"}, std::pair{unit.garbled, "app.scan.some_garbled"},
          std::pair{unit.late, "app.scan.late"}})
        if (applies) text += (text.empty() ? "" : "; ") + texts(code);
    return text;
}

file::Json optional_text(const std::string* text) {
    return text ? file::Json(printable(*text, text->size())) : file::Json();
}

file::Json found_device_json(const FoundDevice& device) {
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
    for (std::size_t id = 0; id < kObjects.size(); ++id)
        object.set(kObjects[id], optional_text(unit.identity.find(static_cast<std::uint8_t>(id))));
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
        case ScanTrouble::Kind::foreign_master: return "strangers";
    }
    return "error";
}

}  // namespace

std::string identity_text(const bus::UnitIdentity& identity) {
    std::string text;
    constexpr std::array<std::uint8_t, 5> kShownObjects{0, 4, 5, 1, 2};
    for (const auto id : kShownObjects) {
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
                            texts.duration(device.unit.response_time));
    for (const auto& part : {identity_text(device.unit.identity), proof_text(texts, device.unit),
                             found_unit_remarks(texts, device.unit)})
        if (!part.empty()) line += "  " + part;
    return line;
}

std::string trouble_line(const Texts& texts, const ScanTrouble& trouble) {
    const auto where = url_of(trouble.line);
    switch (trouble.kind) {
        case ScanTrouble::Kind::error: return texts.describe(trouble.error);
        case ScanTrouble::Kind::garbled:
            if (trouble.error.code != Code{}) {
                auto error = trouble.error;
                error.subject = std::string_view(fmt::format("{} --unit {}", where, trouble.unit));
                return texts.describe(error);
            }
            return texts("app.scan.garbled", {{"target", where}, {"unit", std::to_string(trouble.unit)}});
        case ScanTrouble::Kind::busy: return texts("app.scan.busy", {{"target", where}});
        case ScanTrouble::Kind::foreign_master: return texts("app.scan.foreign_masters", {{"target", where}});
    }
    return {};
}

file::Json scan_json(const Texts& texts, const ScanFindings& findings) {
    auto devices = file::Json::array();
    for (const auto& device : findings.devices) devices.push_back(found_device_json(device));
    auto troubles = file::Json::array();
    for (const auto& trouble : findings.troubles) {
        auto entry = file::Json::object();
        entry.set("kind", kind_name(trouble.kind));
        entry.set("target", url_of(trouble.line));
        entry.set("unit",
                  trouble.kind == ScanTrouble::Kind::garbled ? file::Json(trouble.unit) : file::Json());
        entry.set("code", trouble.error.code == Code{} ? file::Json() : file::Json(name(trouble.error.code)));
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

FoundNodes found_nodes(const ScanFindings& findings, const bus::DeviceProbes& probes) {
    FoundNodes found{.project = bus::found_project(findings, probes), .lines = {}};
    for (auto& [line, devices] : found.project.lines) {
        auto& node = found.lines.emplace_back(file::line_node(line));
        for (std::size_t i = 0; i < devices.size(); ++i) {
            line.devices[i].comment = identity_text(devices[i]->unit.identity);
            node.entries.back().value.items.push_back(file::device_node(line.devices[i], file::Ranges::all));
        }
    }
    return found;
}

std::string scan_project(const Texts& texts, const ScanFindings& findings, const bus::DeviceProbes& probes) {
    auto found = found_nodes(findings, probes);
    auto text = fmt::format("# {}\n", texts("app.scan.project_head")) +
                file::write_project(file::project_node(std::move(found.lines)));
    const auto append_comment = [&](std::string_view head, const auto& devices) {
        if (devices.empty()) return;
        text += fmt::format("\n# {}\n", texts(head));
        for (const auto* device : devices) text += "# " + device_line(texts, *device) + '\n';
    };
    append_comment("app.scan.project_same", found.project.same);
    append_comment("app.scan.project_others", found.project.others);
    return text;
}

std::string scan_summary(const Texts& texts, const ScanFindings& findings) {
    const Texts::Arguments arguments{{"count", std::to_string(findings.devices.size())},
                                     {"requests", std::to_string(findings.requests)},
                                     {"time", texts.duration(findings.duration)},
                                     {"absent", std::to_string(findings.absent_hosts)}};
    auto text = texts("app.scan.summary", arguments) + '\n';
    if (findings.absent_hosts > 0) text += texts("app.scan.absent", arguments) + '\n';
    if (!findings.complete) text += texts("app.interrupted") + '\n';
    return text;
}

std::string scan_progress(const Texts& texts, const bus::TargetScan& scan, const ScanFindings& findings) {
    const auto& line = scan.line();
    auto text = line.transport == model::Transport::serial
                    ? fmt::format("{} {}", line.port, model::settings_text(line))
                    : model::host_and_port(line.port, line.tcp_port);
    if (scan.settings() > 1) text += fmt::format(" ({}/{})", scan.setting(), scan.settings());
    return text + ", " + texts("app.scan.found", {{"count", std::to_string(findings.devices.size())}});
}

}  // namespace takt::report
