#include "takt/app/summary.hpp"

#include <fmt/format.h>

#include "takt/report/formatting.hpp"
#include "takt/report/text_table.hpp"

namespace takt::app {
namespace {

using Align = report::TextTable::Align;

std::string percent(double part) {
    return fmt::format("{:.1f} %", part * 100);
}

std::string failures(const bus::TransactionCounters& counters) {
    return std::to_string(counters.timeouts + counters.checksums + counters.unexpected + counters.link_lost);
}

std::string exceptions(const bus::TransactionCounters& counters) {
    std::string text;
    for (std::size_t code = 0; code < counters.exceptions_by_code.size(); ++code)
        if (const auto count = counters.exceptions_by_code[code]; count > 0)
            text += fmt::format("{}{}×{}", text.empty() ? "" : " ", count,
                                code == 0 ? "?" : std::to_string(code));
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

std::string requests_text(const Scene& scene, const Texts& texts, std::size_t line_index) {
    const auto& poller = scene.master.line(line_index);
    const auto& line = scene.project.lines[line_index];
    report::TextTable table({Align::left, Align::left, Align::right, Align::right, Align::right, Align::right,
                             Align::left, Align::right, Align::right, Align::left});
    table.add({texts("app.device"), texts("app.request"), texts("app.sent"), texts("app.answered"),
               texts("app.timeouts"), texts("app.faults"), texts("app.exceptions"), texts("app.mean"),
               texts("app.longest"), texts("app.period")});
    for (std::size_t i = 0; i < poller.plan().requests.size(); ++i) {
        const auto& request = poller.plan().requests[i];
        const auto& statistics = poller.request(i);
        const auto& counters = statistics.counters;
        table.add({line.devices[request.device].name, report::request_text(request),
                   std::to_string(counters.sent), std::to_string(counters.answered),
                   std::to_string(counters.timeouts),
                   std::to_string(counters.checksums + counters.unexpected + counters.link_lost),
                   exceptions(counters), report::milliseconds_text(counters.time.mean()),
                   report::milliseconds_text(counters.time.max()), period_text(statistics, texts)});
    }
    return table.render("  ");
}

std::string devices_text(const Scene& scene, const Texts& texts, std::size_t line_index) {
    report::TextTable table(
        {Align::left, Align::left, Align::right, Align::right, Align::right, Align::left, Align::right});
    table.add({texts("app.device"), texts("app.state"), texts("app.sent"), texts("app.answered"),
               texts("app.failed"), texts("app.exceptions"), texts("app.outages")});
    const auto& poller = scene.master.line(line_index);
    const auto& devices = scene.project.lines[line_index].devices;
    for (std::size_t i = 0; i < devices.size(); ++i) {
        const auto& device = poller.device(i);
        table.add({devices[i].name, texts(fmt::format("app.state.{}", poll::name(device.state))),
                   std::to_string(device.counters.sent), std::to_string(device.counters.answered),
                   failures(device.counters), exceptions(device.counters), std::to_string(device.outages)});
    }
    return table.render("  ");
}

double milliseconds(Duration duration) {
    return static_cast<double>(duration.count()) / 1e6;
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

file::Json line_json(const Scene& scene, std::size_t index, Instant t) {
    const auto& poller = scene.master.line(index);
    const auto& line = scene.project.lines[index];
    const auto statistics = poller.statistics(t);
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
        device.set("state", poll::name(poller.device(i).state));
        device.set("outages", poller.device(i).outages);
        device.set("verified", poller.device(i).verified);
        device.set("differed", poller.device(i).differed);
        device.set("counters", counters_json(poller.device(i).counters));
        devices.push_back(std::move(device));
    }
    object.set("devices", std::move(devices));
    auto requests = file::Json::array();
    for (std::size_t i = 0; i < poller.plan().requests.size(); ++i) {
        const auto& request = poller.plan().requests[i];
        const auto& measured = poller.request(i);
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

std::string summary_text(const Scene& scene, const Texts& texts, Instant t) {
    std::string text;
    for (std::size_t i = 0; i < scene.project.lines.size(); ++i) {
        const auto statistics = scene.master.line(i).statistics(t);
        text += texts("app.summary.line", {{"line", scene.project.lines[i].name},
                                           {"duration", report::seconds_text(t - scene.start)},
                                           {"planned", report::milliseconds_text(statistics.planned_cycle)},
                                           {"measured", report::milliseconds_text(statistics.measured_cycle)},
                                           {"utilization", percent(statistics.utilization)}});
        text += '\n' + devices_text(scene, texts, i) + '\n' + requests_text(scene, texts, i);
    }
    return text;
}

file::Json summary_json(const Scene& scene, Instant t) {
    auto object = file::Json::object();
    object.set("event", "summary");
    object.set("duration_ms", milliseconds(t - scene.start));
    auto lines = file::Json::array();
    for (std::size_t i = 0; i < scene.project.lines.size(); ++i) lines.push_back(line_json(scene, i, t));
    object.set("lines", std::move(lines));
    return object;
}

}  // namespace takt::app
