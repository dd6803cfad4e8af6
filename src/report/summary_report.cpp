#include "takt/report/summary_report.hpp"

#include <fmt/format.h>

#include "takt/report/formatting.hpp"
#include "takt/report/text_table.hpp"

namespace takt::report {
namespace {

using Align = report::TextTable::Align;

std::string failures(const bus::TransactionCounters& counters) {
    return std::to_string(counters.timeouts + counters.checksums + counters.unexpected + counters.link_lost);
}

std::string exceptions(const bus::TransactionCounters& counters, const Texts& texts) {
    std::string text;
    for (std::size_t code = 0; code < counters.exceptions_by_code.size(); ++code)
        if (const auto count = counters.exceptions_by_code[code]; count > 0)
            text += (text.empty() ? "" : ", ") +
                    texts("app.exceptions.of_code", {{"count", std::to_string(count)},
                                                     {"code", code == 0 ? "?" : std::to_string(code)}});
    return text;
}

std::string period_text(const poll::RequestStatistics& request, const Texts& texts) {
    if (!request.period) return texts("app.on_demand");
    if (request.real_period.count() == 0) return report::milliseconds_text(*request.period);
    return fmt::format(
        "{} → {}{}", report::milliseconds_text(*request.period),
        report::milliseconds_text(request.overrun ? request.recent_period : request.real_period.mean()),
        request.overrun ? " !" : "");
}

std::string requests_text(const host::Snapshot& snapshot, const Texts& texts, std::size_t line_index) {
    const auto& state = snapshot.lines[line_index];
    const auto& line = snapshot.configuration->project().lines[line_index];
    report::TextTable table({Align::left, Align::left, Align::right, Align::right, Align::right, Align::right,
                             Align::left, Align::right, Align::right, Align::left});
    table.add({texts("app.device"), texts("app.request"), texts("app.sent"), texts("app.answered"),
               texts("app.timeouts"), texts("app.faults"), texts("app.exceptions"), texts("app.mean"),
               texts("app.longest"), texts("app.period")});
    for (std::size_t i = 0; i < state.plan->requests.size(); ++i) {
        const auto& request = state.plan->requests[i];
        const auto& statistics = state.requests[i];
        const auto& counters = statistics.counters;
        table.add({line.devices[request.device].name, report::request_text(request),
                   std::to_string(counters.sent), std::to_string(counters.answered),
                   std::to_string(counters.timeouts),
                   std::to_string(counters.checksums + counters.unexpected + counters.link_lost),
                   exceptions(counters, texts), report::milliseconds_text(counters.time.mean()),
                   report::milliseconds_text(counters.time.max()), period_text(statistics, texts)});
    }
    return table.render("  ");
}

std::string devices_text(const host::Snapshot& snapshot, const Texts& texts, std::size_t line_index) {
    report::TextTable table(
        {Align::left, Align::left, Align::right, Align::right, Align::right, Align::left, Align::right});
    table.add({texts("app.device"), texts("app.state"), texts("app.sent"), texts("app.answered"),
               texts("app.failed"), texts("app.exceptions"), texts("app.outages")});
    const auto& state = snapshot.lines[line_index];
    const auto& devices = snapshot.configuration->project().lines[line_index].devices;
    for (std::size_t i = 0; i < devices.size(); ++i) {
        const auto& device = state.devices[i];
        table.add({devices[i].name, texts(fmt::format("app.state.{}", poll::name(device.state))),
                   std::to_string(device.counters.sent), std::to_string(device.counters.answered),
                   failures(device.counters), exceptions(device.counters, texts),
                   std::to_string(device.outages)});
    }
    return table.render("  ");
}

file::Json function_json(const std::optional<wire::Function>& function) {
    return function ? file::Json(static_cast<int>(*function)) : file::Json();
}

file::Json counters_json(const bus::TransactionCounters& counters) {
    auto object = file::Json::object();
    object.set("sent", counters.sent);
    object.set("answered", counters.answered);
    object.set("timeouts", counters.timeouts);
    object.set("checksums", counters.checksums);
    object.set("unexpected", counters.unexpected);
    object.set("link_lost", counters.link_lost);
    object.set("exceptions", counters.exceptions);
    auto codes = file::Json::object();
    for (std::size_t code = 0; code < counters.exceptions_by_code.size(); ++code)
        if (const auto count = counters.exceptions_by_code[code]; count > 0)
            codes.set(code == 0 ? "other" : std::to_string(code), count);
    object.set("exceptions_by_code", std::move(codes));
    object.set("mean_ms", milliseconds(counters.time.mean()));
    object.set("longest_ms", milliseconds(counters.time.max()));
    return object;
}

file::Json line_json(const host::Snapshot& snapshot, std::size_t index) {
    const auto& state = snapshot.lines[index];
    const auto& line = snapshot.configuration->project().lines[index];
    const auto& statistics = state.statistics;
    auto object = file::Json::object();
    object.set("name", line.name);
    object.set("planned_cycle_ms", milliseconds(statistics.planned_cycle));
    object.set("measured_cycle_ms", milliseconds(statistics.measured_cycle));
    object.set("utilization", statistics.utilization);
    auto counters = counters_json(statistics.counters);
    counters.set("foreign_frames", statistics.counters.foreign_frames);
    counters.set("late_answers", statistics.counters.late_answers);
    counters.set("faults", statistics.counters.faults);
    counters.set("unsolicited_bytes", statistics.counters.unsolicited_bytes);
    counters.set("echoes", statistics.counters.echoes);
    object.set("counters", std::move(counters));
    auto devices = file::Json::array();
    for (std::size_t i = 0; i < line.devices.size(); ++i) {
        auto device = file::Json::object();
        device.set("name", line.devices[i].name);
        device.set("state", poll::name(state.devices[i].state));
        device.set("outages", state.devices[i].outages);
        device.set("verified", state.devices[i].verified);
        device.set("differed", state.devices[i].differed);
        device.set("counters", counters_json(state.devices[i].counters));
        devices.push_back(std::move(device));
    }
    object.set("devices", std::move(devices));
    auto requests = file::Json::array();
    for (std::size_t i = 0; i < state.plan->requests.size(); ++i) {
        const auto& request = state.plan->requests[i];
        const auto& measured = state.requests[i];
        auto entry = file::Json::object();
        entry.set("device", line.devices[request.device].name);
        entry.set("function", function_json(request.read));
        entry.set("write_function", function_json(request.write));
        entry.set("start", request.start);
        entry.set("quantity", request.quantity);
        entry.set("period_ms", measured.period ? file::Json(milliseconds(*measured.period)) : file::Json());
        entry.set("real_period_ms", measured.real_period.count() > 0
                                        ? file::Json(milliseconds(measured.real_period.mean()))
                                        : file::Json());
        entry.set("overrun", measured.overrun);
        entry.set("skipped", measured.skipped);
        entry.set("counters", counters_json(measured.counters));
        requests.push_back(std::move(entry));
    }
    object.set("requests", std::move(requests));
    return object;
}

}  // namespace

std::string summary_text(const Texts& texts, const host::Snapshot& snapshot) {
    const auto& lines = snapshot.configuration->project().lines;
    std::string text;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        const auto& statistics = snapshot.lines[i].statistics;
        text += texts("app.summary.line", {{"line", lines[i].name},
                                           {"duration", seconds_text(snapshot.t - snapshot.started)},
                                           {"planned", milliseconds_text(statistics.planned_cycle)},
                                           {"measured", milliseconds_text(statistics.measured_cycle)},
                                           {"utilization", percent_text(statistics.utilization)}});
        text += '\n' + devices_text(snapshot, texts, i) + '\n' + requests_text(snapshot, texts, i);
    }
    return text;
}

file::Json summary_json(const host::Snapshot& snapshot) {
    auto object = file::Json::object();
    object.set("event", "summary");
    object.set("duration_ms", milliseconds(snapshot.t - snapshot.started));
    auto lines = file::Json::array();
    for (std::size_t i = 0; i < snapshot.lines.size(); ++i) lines.push_back(line_json(snapshot, i));
    object.set("lines", std::move(lines));
    return object;
}

}  // namespace takt::report
