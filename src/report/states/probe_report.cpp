#include "takt/report/states/probe_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "takt/bus/found_project.hpp"
#include "takt/file/convert.hpp"
#include "takt/file/project_nodes.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/progress_text.hpp"

namespace takt::report {
namespace {

using bus::AreaProbe;
using bus::ProbeEnd;
using bus::ProbeFindings;
using file::Json;

std::string_view probe_end_word(ProbeEnd end) {
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

/// The exception code of a refused item.
int exception_of(bus::ProbeReply reply) {
    const auto code = reply == bus::ProbeReply::bad_value ? wire::ExceptionCode::illegal_data_value
                                                          : wire::ExceptionCode::server_device_failure;
    return static_cast<int>(code);
}

/// The part of the search that was carried out; empty: the area could not be searched.
std::string searched_extent(const Texts& texts, const AreaProbe& area) {
    const auto& result = area.result;
    const auto gap = area.longest_gap();
    const Texts::Arguments arguments{
        {"area", std::string(wire::name(area.area))},
        {"step", std::to_string(area.step)},
        {"next", std::to_string(result.next)},
        {"requests", std::to_string(result.requests)},
        {"range", range_text(area.searched)},
        {"addresses", std::to_string(area.addresses())},
        {"tested", std::to_string(area.tested())},
        {"whole", result.tested.empty() ? std::string() : range_text(result.tested.front())},
        {"gap", gap ? range_text(*gap) : std::string("0")}};
    if (result.end != ProbeEnd::complete)
        return texts(fmt::format("app.probe.{}", probe_end_word(result.end)), arguments);
    return texts(gap ? "app.probe.step" : "app.probe.all_tested", arguments);
}

std::string probe_remarks(const Texts& texts, const AreaProbe& area) {
    const auto& result = area.result;
    const std::string area_name(wire::name(area.area));
    std::string text = searched_extent(texts, area) + '\n';
    if (result.limited)
        text +=
            texts("app.probe.limited", {{"area", area_name}, {"longest", std::to_string(result.longest)}}) +
            '\n';
    for (const auto& [range, reply] : result.refused)
        text += texts("app.probe.refused", {{"area", area_name},
                                            {"range", range_text(range)},
                                            {"exception", std::to_string(exception_of(reply))}}) +
                '\n';
    if (result.one_refusal) text += texts("app.probe.one_refusal", {{"area", area_name}}) + '\n';
    return text;
}

Json range_pairs_json(const std::vector<model::ItemRange>& ranges) {
    auto list = Json::array();
    for (const auto& range : ranges) list.push_back(Json(Json::Array{range.first, range.last}));
    return list;
}

Json refused_items_json(const AreaProbe& area) {
    auto list = Json::array();
    for (const auto& [range, reply] : area.result.refused) {
        auto entry = Json::object();
        entry.set("first", range.first);
        entry.set("last", range.last);
        entry.set("exception", exception_of(reply));
        list.push_back(std::move(entry));
    }
    return list;
}

Json area_probe_json(const AreaProbe& area) {
    const auto& result = area.result;
    auto object = Json::object();
    object.set("area", wire::name(area.area));
    object.set("function", static_cast<int>(wire::read_function(area.area)));
    object.set("end", probe_end_word(result.end));
    object.set("ranges", range_pairs_json(result.readable));
    object.set("items", static_cast<std::uint64_t>(area.items()));
    object.set("refused", refused_items_json(area));
    object.set("longest_read", result.longest);
    object.set("limited", result.limited);
    object.set("step", area.step);
    object.set("requests", static_cast<std::uint64_t>(result.requests));
    object.set("next", result.next > 65535 ? Json() : Json(result.next));
    object.set("addresses", static_cast<std::uint64_t>(area.addresses()));
    object.set("tested", static_cast<std::uint64_t>(area.tested()));
    object.set("tested_ranges", range_pairs_json(result.tested));
    const auto gap = area.longest_gap();
    object.set("longest_gap", gap ? Json(Json::Array{gap->first, gap->last}) : Json());
    return object;
}

}  // namespace

std::string probe_progress(const bus::ProbeProgress& progress) {
    return fmt::format("{} {}", wire::name(progress.area), progress.start);
}

std::string probe_text(const ProbeFindings& findings) {
    std::string text;
    for (const auto& area : findings.areas) {
        for (const auto& range : area.result.readable)
            text += fmt::format("{} {}\n", wire::name(area.area), range_text(range));
        for (const auto& [range, reply] : area.result.refused)
            text += fmt::format("{} {} exception {}\n", wire::name(area.area), range_text(range),
                                exception_of(reply));
    }
    return text;
}

model::Node probe_keys(const ProbeFindings& findings) {
    if (!findings.any_readable()) return {};
    model::Device device{.group_requests = true};
    bus::set_ranges(device, findings);
    return file::range_keys(device, file::Ranges::all);
}

std::string probe_yaml(const ProbeFindings& findings) {
    return file::write_device_keys(probe_keys(findings));
}

Json probe_json(const ProbeFindings& findings, const ProbeRun& run) {
    auto areas = Json::array();
    auto readable = Json::object();
    for (const auto& area : findings.areas) {
        areas.push_back(area_probe_json(area));
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
    for (const auto& area : findings.areas) text += probe_remarks(texts, area);
    std::string not_begun;
    for (const auto area : findings.not_begun)
        not_begun.append(not_begun.empty() ? "" : ", ").append(wire::name(area));
    if (!not_begun.empty()) text += texts("app.probe.not_begun", {{"areas", not_begun}}) + '\n';
    return text +
           texts("app.probe.summary", {{"requests", std::to_string(findings.requests())},
                                       {"sent", std::to_string(run.transmissions)},
                                       {"time", texts.duration(run.duration)}}) +
           '\n';
}

}  // namespace takt::report
