#include "takt/report/summary_report.hpp"

#include <fmt/format.h>

#include "takt/report/event_report.hpp"
#include "takt/report/formatting.hpp"
#include "takt/report/response_times_report.hpp"
#include "takt/report/text_table.hpp"

namespace takt::report {
namespace {

using Align = report::TextTable::Align;

std::string failures(const bus::TransactionCounters& counters) {
    return std::to_string(counters.timeouts + counters.checksums + counters.unexpected + counters.ambiguous +
                          counters.link_lost);
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

/// "–" if nothing was measured.
std::string measured_text(bool measured, Duration time) {
    return measured ? milliseconds_text(time) : "–";
}

file::Json measured_json(bool measured, Duration time) {
    return measured ? file::Json(milliseconds(time)) : file::Json();
}

std::string period_text(const poll::RequestStatistics& request, const Texts& texts) {
    if (!request.period) return texts("app.on_demand");
    const Duration real = request.overrun ? request.recent_period : request.real_period.mean();
    return fmt::format("{} → {}{}", milliseconds_text(*request.period),
                       measured_text(request.real_period.count() > 0, real), request.overrun ? " !" : "");
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
        table.add(
            {line.devices[request.device].name, report::request_text(request), std::to_string(counters.sent),
             std::to_string(counters.answered), std::to_string(counters.timeouts),
             std::to_string(counters.checksums + counters.unexpected + counters.ambiguous +
                            counters.link_lost),
             exceptions(counters, texts), measured_text(counters.time.count() > 0, counters.time.mean()),
             measured_text(counters.time.count() > 0, counters.time.max()), period_text(statistics, texts)});
    }
    return table.render("  ");
}

std::string devices_text(const host::Snapshot& snapshot, const Texts& texts, std::size_t line_index) {
    report::TextTable table({Align::left, Align::left, Align::right, Align::right, Align::right, Align::left,
                             Align::right, Align::right, Align::right});
    table.add({texts("app.device"), texts("app.state"), texts("app.sent"), texts("app.answered"),
               texts("app.failed"), texts("app.exceptions"), texts("app.outages"), texts("app.downtime"),
               texts("app.available")});
    const auto& state = snapshot.lines[line_index];
    const auto& devices = snapshot.configuration->project().lines[line_index].devices;
    for (std::size_t i = 0; i < devices.size(); ++i) {
        const auto& device = state.devices[i];
        const auto availability = device.availability.at(snapshot.t);
        table.add({devices[i].name, texts(fmt::format("app.state.{}", poll::name(device.state))),
                   std::to_string(device.counters.sent), std::to_string(device.counters.answered),
                   failures(device.counters), exceptions(device.counters, texts),
                   std::to_string(device.outages), downtime_text(availability.downtime),
                   availability_text(availability.share())});
    }
    return table.render("  ");
}

/// A line for each device that is slower than a setting says, and for each with noise before its responses.
std::string findings_text(const host::Snapshot& snapshot, const Texts& texts, std::size_t line) {
    std::string text;
    const auto& devices = snapshot.lines[line].devices;
    for (std::size_t i = 0; i < devices.size(); ++i) {
        const auto add = [&](const auto& found) {
            text += "  " + event_text(texts, *snapshot.configuration, {.body = found}) + '\n';
        };
        if (const auto& finding = devices[i].delays)
            add(host::DelaysFound{.line = line, .device = i, .finding = *finding});
        if (const auto& finding = devices[i].noise)
            add(host::NoiseFound{.line = line, .device = i, .finding = *finding});
    }
    return text;
}

std::string times_text(const host::Snapshot& snapshot, const Texts& texts, std::size_t line) {
    std::string text;
    const auto& devices = snapshot.configuration->project().lines[line].devices;
    for (std::size_t i = 0; i < devices.size(); ++i)
        text += response_times_text(texts, devices[i], snapshot.lines[line].times[i]);
    return text;
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
    object.set("ambiguous", counters.ambiguous);
    object.set("link_lost", counters.link_lost);
    object.set("exceptions", counters.exceptions);
    auto codes = file::Json::object();
    for (std::size_t code = 0; code < counters.exceptions_by_code.size(); ++code)
        if (const auto count = counters.exceptions_by_code[code]; count > 0)
            codes.set(code == 0 ? "other" : std::to_string(code), count);
    object.set("exceptions_by_code", std::move(codes));
    const bool measured = counters.time.count() > 0;
    object.set("mean_ms", measured_json(measured, counters.time.mean()));
    object.set("longest_ms", measured_json(measured, counters.time.max()));
    return object;
}

file::Json delays_json(const std::optional<poll::DelayFinding>& finding) {
    if (!finding) return {};
    auto object = file::Json::object();
    set_delay_finding(object, *finding);
    return object;
}

file::Json noise_json(const std::optional<poll::NoiseFinding>& finding) {
    if (!finding) return {};
    auto object = file::Json::object();
    set_noise_finding(object, *finding);
    return object;
}

file::Json line_json(const host::Snapshot& snapshot, std::size_t index) {
    const auto& state = snapshot.lines[index];
    const auto& line = snapshot.configuration->project().lines[index];
    const auto& statistics = state.statistics;
    auto object = file::Json::object();
    object.set("name", line.name);
    object.set("planned_cycle_ms", milliseconds(statistics.planned_cycle));
    object.set("measured_cycle_ms",
               measured_json(statistics.measured_cycle > Duration::zero(), statistics.measured_cycle));
    object.set("utilization", statistics.utilization);
    set_availability(object, statistics.availability.at(snapshot.t));
    auto counters = counters_json(statistics.counters);
    counters.set("foreign_frames", statistics.counters.foreign_frames);
    counters.set("late_answers", statistics.counters.late_answers);
    counters.set("faults", statistics.counters.faults);
    counters.set("unsolicited_bytes", statistics.counters.unsolicited_bytes);
    counters.set("echoes", statistics.counters.echoes);
    counters.set("noisy_answers", statistics.counters.noisy_answers);
    counters.set("noise_bytes", statistics.counters.noise_bytes);
    object.set("counters", std::move(counters));
    auto devices = file::Json::array();
    for (std::size_t i = 0; i < line.devices.size(); ++i) {
        auto device = file::Json::object();
        device.set("name", line.devices[i].name);
        device.set("state", poll::name(state.devices[i].state));
        device.set("outages", state.devices[i].outages);
        set_availability(device, state.devices[i].availability.at(snapshot.t));
        device.set("late_answers", state.devices[i].late);
        device.set("delays", delays_json(state.devices[i].delays));
        device.set("noisy_answers", state.devices[i].counters.noisy_answers);
        device.set("noise_bytes", state.devices[i].counters.noise_bytes);
        device.set("noise", noise_json(state.devices[i].noise));
        device.set("turnaround", turnaround_json(line.devices[i], state.times[i]));
        device.set("late_responses", late_responses_json(state.times[i]));
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
        entry.set("real_period_ms",
                  measured_json(measured.real_period.count() > 0, measured.real_period.mean()));
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
        text += texts(
            "app.summary.line",
            {{"line", lines[i].name},
             {"duration", seconds_text(snapshot.t - snapshot.started)},
             {"planned", milliseconds_text(statistics.planned_cycle)},
             {"measured", measured_text(statistics.measured_cycle > Duration{}, statistics.measured_cycle)},
             {"utilization", percent_text(statistics.utilization)}});
        const auto availability = statistics.availability.at(snapshot.t);
        text += "\n  " +
                texts("app.summary.availability", {{"available", availability_text(availability.share())},
                                                   {"down", downtime_text(availability.downtime)}});
        text += '\n' + devices_text(snapshot, texts, i) + findings_text(snapshot, texts, i) +
                times_text(snapshot, texts, i) + '\n' + requests_text(snapshot, texts, i);
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
