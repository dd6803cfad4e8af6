#include "takt/report/states/summary_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <string_view>
#include <utility>
#include <vector>

#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/text_table.hpp"
#include "takt/report/drawing/word_wrap.hpp"
#include "takt/report/states/event_report.hpp"
#include "takt/report/states/line_times_report.hpp"
#include "takt/report/states/state_report.hpp"
#include "takt/report/times/response_times_report.hpp"

namespace takt::report {
namespace {

using Align = TextTable::Align;

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
std::string measured_text(const Texts& texts, bool measured, Duration time) {
    return measured ? texts.duration(time) : "–";
}

file::Json measured_json(bool measured, Duration time) {
    return measured ? file::Json(milliseconds(time)) : file::Json();
}

std::string request_period_text(const poll::RequestStatistics& request, const Texts& texts) {
    if (!request.period) return texts("app.on_demand");
    const Duration real = request.overrun ? request.recent_period : request.real_period.mean();
    return fmt::format("{} → {}{}", texts.duration(*request.period),
                       measured_text(texts, request.real_period.count() > 0, real),
                       request.overrun ? " !" : "");
}

/// "time-outs: 3"; empty for 0.
std::string counted(const Texts& texts, std::string_view code, std::uint64_t count) {
    return count == 0 ? std::string() : texts(code) + ": " + std::to_string(count);
}

std::string joined(std::initializer_list<std::string> parts) {
    std::string text;
    for (const auto& part : parts)
        if (!part.empty()) text += (text.empty() ? "" : ", ") + part;
    return text;
}

/// Where the counts of failures are: in columns of the table, or below its rows.
enum class Failures : std::uint8_t { in_columns, below };

/// Rows of counts with the failures of each, as columns or in words.
class CountTable {
public:
    CountTable(Failures where, const std::vector<Align>& all, const std::vector<Align>& without_failures)
        : where_(where), rows_(where == Failures::in_columns ? all : without_failures) {}

    /// The first one is the heading.
    /// @param failed  the cells that leave the table where failures are below, between `first` and `last`
    /// @param words   the failures below the row
    void add(std::vector<std::string> first, const std::vector<std::string>& failed,
             const std::vector<std::string>& last, std::string words = {}) {
        if (where_ == Failures::in_columns) first.insert(first.end(), failed.begin(), failed.end());
        first.insert(first.end(), last.begin(), last.end());
        rows_.add(std::move(first));
        below_.push_back(where_ == Failures::below ? std::move(words) : std::string());
    }

    [[nodiscard]] std::string text(std::size_t columns) const {
        constexpr std::string_view kIndent = "  ";
        const auto lines = rows_.lines(columns - std::min(columns, kIndent.size()));
        std::string text;
        for (std::size_t i = 0; i < lines.size(); ++i) {
            text.append(kIndent).append(lines[i]) += '\n';
            if (!below_[i].empty()) text += "      └ " + below_[i] + '\n';
        }
        return text;
    }

private:
    Failures where_;
    TextTable rows_;
    std::vector<std::string> below_;
};

bool fits(const std::string& text, std::size_t columns) {
    for (std::size_t begin = 0, end = 0; begin < text.size(); begin = end + 1) {
        end = text.find('\n', begin);
        if (display_width(std::string_view(text).substr(begin, end - begin)) > columns) return false;
    }
    return true;
}

/// The table with all columns, or, where it is wider than the terminal, with the failures below.
/// @param make  makes the table
template <typename Make>
std::string fitting_text(const Make& make, std::size_t columns) {
    auto text = make(Failures::in_columns).text(SIZE_MAX);
    return fits(text, columns) ? text : make(Failures::below).text(columns);
}

std::uint64_t failed_exchanges(const bus::TransactionCounters& counters) {
    return counters.checksums + counters.unexpected + counters.ambiguous + counters.link_lost;
}

/// Without columns for failures there is none for the answers either: they are all others.
CountTable request_table(const host::Snapshot& snapshot, const Texts& texts, std::size_t line_index,
                         Failures where) {
    const auto& state = snapshot.lines[line_index];
    const auto& line = snapshot.configuration->project().lines[line_index];
    using enum TextTable::Align;
    CountTable table(where, {left, left, right, right, right, right, left, right, right, left},
                     {left, whole, right, right, right, whole});
    table.add({texts("app.device"), texts("app.request"), texts("app.sent")},
              {texts("app.answered"), texts("app.timeouts"), texts("app.faults"), texts("app.exceptions")},
              {texts("app.mean"), texts("app.longest"), texts("app.period_answered")});
    for (std::size_t i = 0; i < state.plan->requests.size(); ++i) {
        const auto& request = state.plan->requests[i];
        const auto& statistics = state.requests[i];
        const auto& counters = statistics.counters;
        const bool measured = counters.time.count() > 0;
        table.add(
            {line.devices[request.device].name, request_text(request), std::to_string(counters.sent)},
            {std::to_string(counters.answered), std::to_string(counters.timeouts),
             std::to_string(failed_exchanges(counters)), exceptions(counters, texts)},
            {measured_text(texts, measured, counters.time.mean()),
             measured_text(texts, measured, counters.time.max()), request_period_text(statistics, texts)},
            joined({counted(texts, "app.timeouts", counters.timeouts),
                    counted(texts, "app.faults", failed_exchanges(counters)), exceptions(counters, texts)}));
    }
    return table;
}

CountTable device_table(const host::Snapshot& snapshot, const Texts& texts, std::size_t line_index,
                        Failures where) {
    using enum TextTable::Align;
    CountTable table(where, {left, left, right, right, right, left, right, right, right},
                     {left, whole, right, right, right, right, right});
    table.add({texts("app.device"), texts("app.state"), texts("app.sent"), texts("app.answered")},
              {texts("app.failed"), texts("app.exceptions")},
              {texts("app.outages"), texts("app.downtime"), texts("app.available")});
    const auto& state = snapshot.lines[line_index];
    const auto& devices = snapshot.configuration->project().lines[line_index].devices;
    for (std::size_t i = 0; i < devices.size(); ++i) {
        const auto& device = state.devices[i];
        const auto availability = device.availability.at(snapshot.t);
        const auto failed = device.counters.timeouts + failed_exchanges(device.counters);
        table.add({devices[i].name, device_state_text(texts, device), std::to_string(device.counters.sent),
                   std::to_string(device.counters.answered)},
                  {std::to_string(failed), exceptions(device.counters, texts)},
                  {std::to_string(device.outages), texts.duration(availability.downtime),
                   availability_text(availability.share())},
                  joined({counted(texts, "app.failed", failed), exceptions(device.counters, texts)}));
    }
    return table;
}

/// A line for each device that is slower than a setting says, with noise before its responses, or
/// with responses that no request asked for.
std::string device_findings_text(const host::Snapshot& snapshot, const Texts& texts, std::size_t line) {
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
        if (devices[i].shifted) add(host::SurplusFound{.line = line, .device = i});
    }
    return text;
}

/// Bytes between the transactions, as a driver that is disabled too late sends them after a response. Where
/// late or foreign frames were received too, their bytes are among the counted ones.
std::string idle_noise_text(const host::Snapshot& snapshot, const Texts& texts, std::size_t index) {
    constexpr std::uint64_t kLeast = 3;
    constexpr std::uint64_t kOneIn = 100;  // responses
    const auto& line = snapshot.configuration->project().lines[index];
    const auto& counters = snapshot.lines[index].statistics.counters;
    const auto bytes = counters.unsolicited_bytes;
    if (line.framing == wire::Framing::tcp || counters.late_answers > 0 || counters.foreign_frames > 0 ||
        bytes < kLeast || bytes * kOneIn < counters.answered + counters.exceptions)
        return {};
    return "  " + texts("app.noise.idle", {{"line", line.name}, {"count", std::to_string(bytes)}}) + '\n';
}

std::string line_response_times_text(const host::Snapshot& snapshot, const Texts& texts, std::size_t line) {
    std::string text;
    const auto& devices = snapshot.configuration->project().lines[line].devices;
    for (std::size_t i = 0; i < devices.size(); ++i)
        text += response_times_text(texts, devices[i], snapshot.lines[line].times[i]);
    if (line < snapshot.line_times.size()) text += line_times_text(texts, snapshot.line_times[line]);
    return text;
}

std::string line_summary_heading(const host::Snapshot& snapshot, const Texts& texts, std::size_t line) {
    const auto& statistics = snapshot.lines[line].statistics;
    const auto availability = statistics.availability.at(snapshot.t);
    return texts("app.summary.line",
                 {{"line", snapshot.configuration->project().lines[line].name},
                  {"duration", texts.duration(snapshot.t - snapshot.started)},
                  {"planned", texts.duration(statistics.planned_cycle)},
                  {"measured",
                   measured_text(texts, statistics.measured_cycle > Duration{}, statistics.measured_cycle)},
                  {"utilization", percent_text(statistics.utilization)}}) +
           "\n  " +
           texts("app.summary.availability", {{"available", availability_text(availability.share())},
                                              {"down", texts.duration(availability.downtime)}}) +
           '\n';
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

file::Json line_summary_json(const host::Snapshot& snapshot, std::size_t index) {
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
        device.set("surplus_answers", state.devices[i].surplus);
        device.set("delays", finding_json(state.devices[i].delays));
        device.set("noisy_answers", state.devices[i].counters.noisy_answers);
        device.set("noise_bytes", state.devices[i].counters.noise_bytes);
        device.set("noise", finding_json(state.devices[i].noise));
        device.set("turnaround", turnaround_json(line.devices[i], state.times[i]));
        device.set("late_responses", late_responses_json(state.times[i]));
        device.set("verified", state.devices[i].verified);
        device.set("differed", state.devices[i].differed);
        device.set("counters", counters_json(state.devices[i].counters));
        devices.push_back(std::move(device));
    }
    object.set("devices", std::move(devices));
    object.set("times", index < snapshot.line_times.size() ? line_times_json(snapshot.line_times[index])
                                                           : file::Json());
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
        entry.set("longer_than_proved", measured.over_cost);
        entry.set("late_refreshes", measured.late_refreshes);
        entry.set("counters", counters_json(measured.counters));
        requests.push_back(std::move(entry));
    }
    object.set("requests", std::move(requests));
    return object;
}

}  // namespace

std::string summary_text(const Texts& texts, const host::Snapshot& snapshot, std::size_t columns) {
    std::string text;
    for (std::size_t i = 0; i < snapshot.lines.size(); ++i) {
        const auto table = [&](const auto& make) {
            return fitting_text([&](Failures where) { return make(snapshot, texts, i, where); }, columns);
        };
        text += (i == 0 ? "" : "\n") + wrapped(line_summary_heading(snapshot, texts, i), columns) +
                table(device_table) +
                wrapped(device_findings_text(snapshot, texts, i) + idle_noise_text(snapshot, texts, i) +
                            line_response_times_text(snapshot, texts, i),
                        columns) +
                '\n' + table(request_table) + wrapped(broken_bounds_text(texts, snapshot, i), columns);
    }
    return text;
}

file::Json summary_json(const host::Snapshot& snapshot) {
    auto object = file::Json::object();
    object.set("event", "summary");
    object.set("duration_ms", milliseconds(snapshot.t - snapshot.started));
    auto lines = file::Json::array();
    for (std::size_t i = 0; i < snapshot.lines.size(); ++i) lines.push_back(line_summary_json(snapshot, i));
    object.set("lines", std::move(lines));
    return object;
}

}  // namespace takt::report
