#include "takt/report/probe_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "takt/report/formatting.hpp"
#include "takt/report/progress_text.hpp"

namespace takt::report {
namespace {

using discover::AreaProbe;
using discover::ProbeEnd;
using discover::ProbeFindings;
using file::Json;

std::string_view name(ProbeEnd end) {
    switch (end) {
        case ProbeEnd::complete: return "complete";
        case ProbeEnd::out_of_requests: return "out_of_requests";
        case ProbeEnd::stopped: break;
        case ProbeEnd::no_function: return "no_function";
        case ProbeEnd::no_answer: return "no_answer";
        case ProbeEnd::fell_silent: return "fell_silent";
    }
    return "stopped";
}

std::string ranges_text(const std::vector<model::ItemRange>& ranges) {
    std::string text;
    for (const auto& range : ranges) text += (text.empty() ? "" : ", ") + range_text(range);
    return text;
}

std::string remarks(const Texts& texts, const AreaProbe& area) {
    const auto& result = area.result;
    const Texts::Arguments arguments{{"area", std::string(wire::name(area.area))},
                                     {"step", std::to_string(area.step)},
                                     {"longest", std::to_string(result.longest)},
                                     {"next", std::to_string(result.next)},
                                     {"requests", std::to_string(result.requests)}};
    std::string text;
    if (result.end != ProbeEnd::complete && result.end != ProbeEnd::stopped)
        text += texts(fmt::format("app.probe.{}", name(result.end)), arguments) + '\n';
    if (result.limited) text += texts("app.probe.limited", arguments) + '\n';
    if (result.end == ProbeEnd::complete && area.step > 1) text += texts("app.probe.step", arguments) + '\n';
    return text;
}

/// The longest read that every area of registers with a limit accepts; 0: there is no limit.
std::size_t registers_per_request(const ProbeFindings& findings) {
    std::size_t least = 0;
    for (const auto& area : findings.areas) {
        const auto& result = area.result;
        if (is_bit_area(area.area) || !result.limited || result.longest < 2) continue;
        least = least == 0 ? result.longest : std::min<std::size_t>(least, result.longest);
    }
    return least;
}

Json area_json(const AreaProbe& area) {
    const auto& result = area.result;
    auto ranges = Json::array();
    for (const auto& range : result.readable) ranges.push_back(Json(Json::Array{range.first, range.last}));
    auto object = Json::object();
    object.set("area", wire::name(area.area));
    object.set("function", static_cast<int>(wire::read_function(area.area)));
    object.set("end", name(result.end));
    object.set("ranges", std::move(ranges));
    object.set("items", static_cast<std::uint64_t>(area.items()));
    object.set("longest_read", result.longest);
    object.set("limited", result.limited);
    object.set("step", area.step);
    object.set("requests", static_cast<std::uint64_t>(result.requests));
    object.set("next", result.next > 65535 ? Json() : Json(result.next));
    return object;
}

}  // namespace

std::string probe_progress(const discover::ProbeProgress& progress) {
    return fmt::format("{} {}", wire::name(progress.area), progress.start);
}

std::string probe_text(const ProbeFindings& findings) {
    std::string text;
    for (const auto& area : findings.areas)
        for (const auto& range : area.result.readable)
            text += fmt::format("{} {}\n", wire::name(area.area), range_text(range));
    return text;
}

std::string probe_yaml(const ProbeFindings& findings) {
    if (!findings.any_readable()) return {};
    std::string text = "readable:\n";
    for (const auto& area : findings.areas)
        if (!area.result.readable.empty())
            text += fmt::format("  {}: [{}]\n", wire::name(area.area), ranges_text(area.result.readable));
    const std::size_t registers = registers_per_request(findings);
    if (registers > 0) text += fmt::format("registers_per_request: {}\n", registers);
    return text;
}

Json probe_json(const ProbeFindings& findings, const ProbeRun& run) {
    auto areas = Json::array();
    auto readable = Json::object();
    for (const auto& area : findings.areas) {
        areas.push_back(area_json(area));
        if (!area.result.readable.empty())
            readable.set(wire::name(area.area), ranges_text(area.result.readable));
    }
    auto exceptions = Json::object();
    for (const auto& [code, count] : findings.exceptions) exceptions.set(std::to_string(code), count);
    auto object = Json::object();
    object.set("target", run.target);
    object.set("unit", run.unit);
    object.set("areas", std::move(areas));
    object.set("readable", std::move(readable));
    object.set("exceptions", std::move(exceptions));
    object.set("requests", static_cast<std::uint64_t>(findings.requests()));
    object.set("transmissions", run.transmissions);
    object.set("duration_ms", run.duration / std::chrono::milliseconds(1));
    object.set("complete", findings.complete());
    return object;
}

std::string probe_summary(const Texts& texts, const ProbeFindings& findings, const ProbeRun& run) {
    std::string text;
    for (const auto& area : findings.areas) text += remarks(texts, area);
    return text +
           texts("app.probe.summary", {{"requests", std::to_string(findings.requests())},
                                       {"sent", std::to_string(run.transmissions)},
                                       {"time", rough_time(run.duration)}}) +
           '\n';
}

}  // namespace takt::report
