#include "takt/report/plans/plan_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <tuple>

#include "states/byte_order_report.hpp"
#include "takt/plan/compare.hpp"
#include "takt/plan/learning.hpp"
#include "takt/plan/shares.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/text_table.hpp"
#include "takt/report/plans/comparison_report.hpp"
#include "takt/report/plans/findings_report.hpp"
#include "takt/report/states/learnt_report.hpp"
#include "takt/report/times/response_times_report.hpp"

namespace takt::report {
namespace {

using Align = TextTable::Align;

constexpr const char* kDash = "–";
constexpr std::string_view kRowIndent = "  ";

std::string baud_text(const model::Line& line) {
    return line.is_serial() ? fmt::format(", {} bit/s", line.format.baud) : std::string();
}

file::Json local_json(const model::Project& project, const std::optional<model::LocalIndex>& local) {
    return local ? file::Json(project.locals[*local].name) : file::Json();
}

file::Json request_json(const Texts& texts, const model::Project& project, const model::Line& line,
                        const plan::Request& request, const plan::LineGuarantee& guarantee,
                        std::size_t number, double share) {
    const auto& device = line.devices[request.device];
    auto object = file::Json::object();
    object.set("device", device.name);
    object.set("unit", device.address.value);
    object.set("function", function_json(request.read));
    object.set("write_function", function_json(request.write));
    object.set("start", request.start);
    object.set("quantity", request.quantity);
    if (request.write_quantity > 0) {
        object.set("write_start", request.write_start);
        object.set("write_quantity", request.write_quantity);
    }
    if (request.read_modify_write) object.set("read_modify_write", true);
    auto names = file::Json::array();
    for (const auto index : request.variables) names.push_back(device.variables[index].name);
    object.set("variables", std::move(names));
    auto orders = file::Json::array();
    for (const auto index : request.variables) orders.push_back(byte_order_json(device.variables[index]));
    object.set("byte_orders", std::move(orders));
    object.set("period_ms", request.period ? file::Json(milliseconds(*request.period)) : file::Json());
    object.set("phase_ms", request.period ? file::Json(milliseconds(request.phase)) : file::Json());
    object.set("read_trigger", local_json(project, request.read_trigger));
    object.set("write_trigger", local_json(project, request.write_trigger));
    object.set("write_on_change", request.write_on_change);
    object.set("bus_time_us", whole_microseconds(request.bus_time));
    object.set("share", share);
    set_bound(object, guarantee.requests[number]);
    object.set("ages_us", ages_json(guarantee, request));
    object.set("why", texts(request.why.code, request.why.arguments));
    if (request.bridged) object.set("bridged", texts(request.bridged->code, request.bridged->arguments));
    return object;
}

bool differ_in_phase(const plan::Request& a, const plan::Request& b) {
    const auto what = [](const plan::Request& r) {
        return std::tie(r.device, r.read, r.write, r.start, r.quantity, r.period, r.read_trigger,
                        r.variables);
    };
    return a.period && !a.read_trigger && !a.write && what(a) == what(b);
}

/// Groups of requests that differ only in their phase, ordered by phase: each group is one row.
std::vector<std::vector<std::size_t>> rows_by_turn(const std::vector<plan::Request>& requests) {
    std::vector<std::vector<std::size_t>> rows;
    for (std::size_t i = 0; i < requests.size(); ++i) {
        if (i > 0 && differ_in_phase(requests[i - 1], requests[i]))
            rows.back().push_back(i);
        else
            rows.push_back({i});
    }
    for (auto& row : rows)
        std::ranges::sort(row, {}, [&requests](std::size_t i) { return requests[i].phase; });
    return rows;
}

/// "1 s +200, 400 ms".
std::string turns_text(const Texts& texts, const std::vector<plan::Request>& requests,
                       const std::vector<std::size_t>& turns) {
    constexpr std::size_t kMostPhases = 6;
    std::string text = texts.duration(*requests[turns.front()].period);
    for (std::size_t i = 0; i < std::min(turns.size(), kMostPhases); ++i)
        text += fmt::format("{}{}", i == 0 ? " +" : ", ", milliseconds(requests[turns[i]].phase));
    text += ' ' + texts("unit.ms");
    if (turns.size() > kMostPhases) text += fmt::format(" … ({})", turns.size());
    return text;
}

/// The columns between the causes of a request and its variables.
std::vector<std::string> figure_headings(const Texts& texts, const plan::LineGuarantee* guarantee,
                                         Figures figures) {
    if (guarantee && figures == Figures::proof) return {"C", "R", texts("app.deadline"), texts("app.oldest")};
    std::vector<std::string> cells{texts("app.bus_time"), texts("app.share")};
    if (guarantee) cells.push_back(texts("app.oldest"));
    return cells;
}

/// @param turns  the requests of one row
std::vector<std::string> figure_cells(const Texts& texts, const plan::LinePlan& planned,
                                      const std::vector<std::size_t>& turns, const plan::Shares& shares,
                                      const plan::LineGuarantee* guarantee, Figures figures) {
    const auto cell = [&](const std::optional<Duration>& time) {
        return time ? texts.bound(*time) : std::string(kDash);
    };
    const auto* const bound = guarantee ? &guarantee->requests[turns.front()] : nullptr;
    if (bound && figures == Figures::proof)
        return {cell(bound->transaction), cell(bound->response), cell(bound->deadline), cell(bound->age)};
    double share = 0;
    for (const std::size_t turn : turns) share += shares.requests[turn];
    std::vector<std::string> cells{texts.duration(planned.requests[turns.front()].bus_time),
                                   share > 0 ? percent_text(share) : kDash};
    if (bound) cells.push_back(cell(bound->age));
    return cells;
}

/// A row for each request. Below it are the gaps that it reads and the reason for its last item.
std::string requests_text(const Texts& texts, const model::Project& project, const plan::LinePlan& planned,
                          const plan::Shares& shares, const plan::LineGuarantee* guarantee,
                          const TableStyle& style) {
    const auto& line = project.lines[planned.line];
    const auto headings = figure_headings(texts, guarantee, style.figures);
    std::vector<Align> columns{Align::left, Align::right, Align::whole, Align::left};
    columns.resize(columns.size() + headings.size(), Align::right);
    columns.push_back(Align::left);
    TextTable table(columns);
    const auto add = [&](std::vector<std::string> cells, const std::vector<std::string>& figure,
                         std::string variables) {
        cells.insert(cells.end(), figure.begin(), figure.end());
        cells.push_back(std::move(variables));
        table.add(std::move(cells));
    };
    add({texts("app.device"), texts("app.unit"), texts("app.request"), texts("app.when")}, headings,
        texts("app.variables"));
    const auto rows_of = rows_by_turn(planned.requests);
    for (const auto& turns : rows_of) {
        const auto& request = planned.requests[turns.front()];
        const auto& device = line.devices[request.device];
        add({device.name, std::to_string(device.address.value), request_text(request),
             turns.size() > 1 ? turns_text(texts, planned.requests, turns)
                              : when_text(texts, project, request)},
            figure_cells(texts, planned, turns, shares, guarantee, style.figures),
            variables_text(device, request));
    }
    const auto rows = table.lines(style.columns - std::min(style.columns, kRowIndent.size()));
    std::string text = std::string(kRowIndent) + rows.front() + '\n';
    for (std::size_t i = 0; i < rows_of.size(); ++i) {
        const auto& request = planned.requests[rows_of[i].front()];
        text += std::string(kRowIndent) + rows[i + 1] + '\n';
        if (request.bridged)
            text += "      ├ " + texts(request.bridged->code, request.bridged->arguments) + '\n';
        text += "      └ " + texts(request.why.code, request.why.arguments) + '\n';
    }
    return text;
}

/// The shares of the devices, the greatest first, and of clients: "Boiler 34.3 %, Pump 2.0 %".
std::string shares_text(const Texts& texts, const model::Line& line, const plan::Shares& shares,
                        const plan::LineGuarantee* guarantee) {
    constexpr std::size_t kMostDevices = 4;
    std::vector<std::size_t> devices;
    for (std::size_t d = 0; d < shares.devices.size(); ++d)
        if (shares.devices[d] > 0) devices.push_back(d);
    std::ranges::stable_sort(devices, std::greater<>(), [&](std::size_t d) { return shares.devices[d]; });
    std::string text;
    const auto append = [&text](const std::string& item) { text += (text.empty() ? "" : ", ") + item; };
    for (std::size_t i = 0; i < std::min(devices.size(), kMostDevices); ++i)
        append(line.devices[devices[i]].name + ' ' + percent_text(shares.devices[devices[i]]));
    if (devices.size() > kMostDevices) append(fmt::format("… ({})", devices.size()));
    const bool relayed = guarantee && guarantee->relayed_share > 0;
    const bool commanded = guarantee && guarantee->client_share > 0;
    if (relayed) append(texts("app.plan.relayed", {{"share", percent_text(guarantee->relayed_share)}}));
    if (commanded) append(texts("app.plan.clients", {{"share", percent_text(guarantee->client_share)}}));
    if (devices.size() < 2 && !relayed && !commanded) return {};
    return "  " + texts("app.plan.shares", {{"shares", text}}) + '\n';
}

file::Json device_shares_json(const model::Line& line, const plan::Shares& shares) {
    auto list = file::Json::array();
    for (std::size_t d = 0; d < line.devices.size(); ++d) {
        auto device = file::Json::object();
        device.set("name", line.devices[d].name);
        device.set("unit", line.devices[d].address.value);
        device.set("share", shares.devices[d]);
        const auto turnaround = line.is_broadcast(line.devices[d]) ? std::optional(Duration::zero())
                                                                   : line.devices[d].expected_turnaround();
        device.set("turnaround_us", turnaround ? file::Json(whole_microseconds(*turnaround)) : file::Json());
        list.push_back(std::move(device));
    }
    return list;
}

}  // namespace

std::string variables_text(const model::Device& device, const plan::Request& request) {
    return plan::names_text(device, request.variables);
}

std::string causes_text(const Texts& texts, const RequestCauses& causes) {
    std::string when;
    const auto append = [&when](const std::string& text) { when += (when.empty() ? "" : ", ") + text; };
    if (causes.period)
        append(*causes.period == Duration::zero() ? texts("app.when.always")
                                                  : turn_text(texts, *causes.period, causes.phase));
    if (!causes.read_trigger.empty())
        append(texts("app.when.read_trigger", {{"local", causes.read_trigger}}));
    if (causes.on_change) append(texts("app.when.change"));
    if (!causes.write_trigger.empty())
        append(texts("app.when.write_trigger", {{"local", causes.write_trigger}}));
    return when;
}

std::string when_text(const Texts& texts, const model::Project& project, const plan::Request& request) {
    const auto name_of = [&project](const std::optional<model::LocalIndex>& local) {
        return local ? project.locals[*local].name : std::string();
    };
    const auto when = causes_text(texts, {.period = request.period,
                                          .phase = request.phase,
                                          .read_trigger = name_of(request.read_trigger),
                                          .on_change = request.write_on_change,
                                          .write_trigger = name_of(request.write_trigger)});
    return when.empty() && request.write ? texts("app.when.command") : when;
}

std::string line_heading(const Texts& texts, const model::Project& project, const plan::LinePlan& planned) {
    const auto& line = project.lines[planned.line];
    const auto [grouped, ungrouped] = plan::request_counts(line, planned);
    auto requests = std::to_string(grouped);
    if (ungrouped != grouped)
        requests =
            texts("app.plan.instead", {{"requests", requests}, {"ungrouped", std::to_string(ungrouped)}});
    return texts("app.plan.line", {{"line", line.name},
                                   {"framing", std::string(wire::name(line.framing)) + baud_text(line)},
                                   {"requests", requests},
                                   {"cycle", texts.duration(planned.cycle)},
                                   {"utilization", percent_text(plan::busy(planned))}});
}

std::string plan_text(const Texts& texts, const model::Project& project, const plan::Plan& plan,
                      std::span<const plan::LineGuarantee> guarantees, const TableStyle& style) {
    std::string text;
    for (std::size_t i = 0; i < plan.lines.size(); ++i) {
        const auto& planned = plan.lines[i];
        const auto& line = project.lines[planned.line];
        const auto* guarantee = i < guarantees.size() ? &guarantees[i] : nullptr;
        text += line_heading(texts, project, planned);
        text += '\n';
        const auto shares = plan::shares(line, planned);
        text += requests_text(texts, project, planned, shares, guarantee, style);
        text += shares_text(texts, line, shares, guarantee);
        if (const auto orders = byte_orders_text(line); !orders.empty())
            text += "  " +
                    texts("app.plan.byte_orders", {{"orders", orders}, {"names", byte_order_names(line)}}) +
                    '\n';
        if (planned.utilization > 1) text += "  " + texts("app.plan.overloaded") + '\n';
        text += learnt_text(texts, project, planned.line);
        text += learnt_times_text(texts, line);
        if (guarantee)
            text += "  " +
                    guarantee_text(texts, *guarantee, plan::verdict(project, planned, *guarantee),
                                   plan::unknown_turnarounds(line)) +
                    '\n';
    }
    if (!plan.lines.empty() && !guarantees.empty())
        text += texts(style.figures == Figures::proof ? "app.plan.legend.proof" : "app.plan.legend") + '\n';
    return text;
}

file::Json plan_json(const Texts& texts, const model::Project& project, const plan::Plan& plan,
                     const plan::Proof& proof, bool compare) {
    const auto comparisons = compare ? plan::compare(project, plan) : std::vector<plan::Comparison>();
    auto lines = file::Json::array();
    for (std::size_t i = 0; i < plan.lines.size(); ++i) {
        const auto& planned = plan.lines[i];
        const auto& line = project.lines[planned.line];
        auto object = file::Json::object();
        object.set("name", line.name);
        object.set("framing", wire::name(line.framing));
        object.set("baud", line.is_serial() ? file::Json(line.format.baud) : file::Json());
        object.set("utilization", plan::busy(planned));
        object.set("cycle_us", whole_microseconds(planned.cycle));
        const auto shares = plan::shares(line, planned);
        auto requests = file::Json::array();
        for (std::size_t r = 0; r < planned.requests.size(); ++r) {
            requests.push_back(request_json(texts, project, line, planned.requests[r], proof.lines[i], r,
                                            shares.requests[r]));
        }
        object.set("requests", std::move(requests));
        object.set("devices", device_shares_json(line, shares));
        object.set("relayed_share", proof.lines[i].relayed_share);
        object.set("client_share", proof.lines[i].client_share);
        object.set("ungrouped_requests", static_cast<std::uint64_t>(planned.ungrouped_requests));
        object.set("request_count", static_cast<std::uint64_t>(planned.request_count));
        object.set("feasible", proof.lines[i].feasible);
        object.set("verdict", plan::name(plan::verdict(project, plan.lines[i], proof.lines[i])));
        object.set("feasible_edf", proof.lines[i].feasible_edf);
        object.set("worst_utilization", proof.lines[i].utilization);
        object.set("exact", proof.lines[i].exact);
        object.set("in_flight", proof.lines[i].in_flight);
        object.set("response_source", plan::name(plan::response_source(line)));
        object.set("measures", measures_json(texts, proof.measures.found, planned.line));
        object.set("measures_complete", !std::ranges::binary_search(proof.measures.unfinished, planned.line));
        if (plan::learns(line)) object.set("learnt", learnt_json(project, planned.line));
        if (auto times = learnt_times_json(line); !std::get<file::Json::Array>(times.value()).empty())
            object.set("response_times", std::move(times));
        if (compare) object.set("compare", comparison_json(comparisons[i]));
        lines.push_back(std::move(object));
    }
    return lines;
}

file::Json project_plan_json(const Texts& texts, const host::LoadedProject& loaded, const plan::Proof& proof,
                             const plan::AppliedMeasures* applied, bool compare) {
    auto object = file::Json::object();
    object.set("lines", plan_json(texts, loaded.project, proof.plan, proof, compare));
    if (applied) object.set("fixed", applied_json(texts, *applied));
    object.set("findings", findings_json(texts, loaded));
    return object;
}

file::Json no_plan_json(const Texts& texts, const host::LoadedProject& loaded) {
    auto object = file::Json::object();
    object.set("lines", file::Json::array());
    object.set("findings", findings_json(texts, loaded));
    return object;
}

std::string applied_text(const Texts& texts, const model::Project& before, const plan::Proof& proof,
                         const plan::AppliedMeasures& applied, const TableStyle& style) {
    std::string text;
    for (const std::size_t line : applied.not_helped)
        text += texts("app.fix.none", {{"line", before.lines[line].name}}) + '\n';
    if (applied.changes.empty()) return applied.not_helped.empty() ? texts("app.fix.nothing") + '\n' : text;
    text += texts("app.fix.before") + '\n' + plan_text(texts, before, proof.plan, proof.lines, style) + '\n';
    text += texts("app.fix.after") + '\n' +
            plan_text(texts, applied.project, applied.proof.plan, applied.proof.lines, style) + '\n';
    return text + texts("app.fix.applied") + '\n' + changes_text(texts, applied.changes);
}

file::Json applied_json(const Texts& texts, const plan::AppliedMeasures& applied) {
    auto object = file::Json::object();
    object.set("changes", changes_json(applied.changes));
    object.set("lines", plan_json(texts, applied.project, applied.proof.plan, applied.proof, false));
    return object;
}

}  // namespace takt::report
