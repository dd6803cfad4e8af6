#include "live/requests_json.hpp"

#include <optional>
#include <utility>

#include "takt/plan/timeline.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/states/line_times_report.hpp"

namespace takt::web {
namespace {

file::Json function_json(const std::optional<wire::Function>& function) {
    return function ? file::Json(static_cast<int>(*function)) : file::Json();
}

file::Json microseconds_or_null(Duration time, bool known) {
    return known ? file::Json(report::whole_microseconds(time)) : file::Json();
}

file::Json names_of(const model::Device& device, const plan::Request& request) {
    auto names = file::Json::array();
    for (const auto variable : request.variables) names.push_back(device.variables[variable].name);
    return names;
}

void set_counters(file::Json& object, const poll::RequestStatistics& statistics,
                  const poll::HistogramSnapshot& times) {
    const auto& counters = statistics.counters;
    object.set("period_ms",
               statistics.period ? file::Json(report::milliseconds(*statistics.period)) : file::Json());
    object.set("real_period_ms", statistics.real_period.count() > 0
                                     ? file::Json(report::milliseconds(statistics.recent_period))
                                     : file::Json());
    object.set("sent", counters.sent);
    object.set("answered", counters.answered);
    object.set("timeouts", counters.timeouts);
    object.set("faults", counters.checksums + counters.unexpected + counters.ambiguous);
    object.set("exceptions", counters.exceptions);
    const bool measured = counters.time.count() > 0;
    object.set("mean_us", microseconds_or_null(counters.time.mean(), measured));
    object.set("p50_us", microseconds_or_null(times.p50, measured));
    object.set("p99_us", microseconds_or_null(times.p99, measured));
    object.set("longest_us", microseconds_or_null(counters.time.max(), measured));
    object.set("histogram", report::histogram_json(times));
    object.set("longer_than_proved", statistics.over_cost);
    object.set("late_refreshes", statistics.late_refreshes);
}

file::Json request_json(const model::Line& line, const plan::Request& request,
                        const poll::RequestStatistics& statistics, const poll::HistogramSnapshot& times) {
    const auto& device = line.devices[request.device];
    auto object = file::Json::object();
    object.set("device", device.name);
    object.set("unit", device.address.value);
    object.set("function", function_json(request.read));
    object.set("write_function", function_json(request.write));
    object.set("start", request.start);
    object.set("quantity", request.quantity);
    object.set("variables", names_of(device, request));
    set_counters(object, statistics, times);
    object.set("planned_us", report::whole_microseconds(request.bus_time));
    return object;
}

}  // namespace

file::Json requests_json(const host::Snapshot& snapshot) {
    auto lines = file::Json::array();
    const auto& project = snapshot.configuration->project();
    for (std::size_t i = 0; i < snapshot.lines.size(); ++i) {
        const auto& line = snapshot.lines[i];
        auto object = file::Json::object();
        object.set("name", project.lines[i].name);
        object.set("utilization", line.statistics.recent_utilization);
        object.set("cycle_us", report::whole_microseconds(line.statistics.planned_cycle));
        object.set("measured_cycle_us", microseconds_or_null(line.statistics.measured_cycle,
                                                             line.statistics.measured_cycle > Duration{}));
        object.set("times", report::line_times_json(snapshot.line_times[i]));
        auto requests = file::Json::array();
        for (std::size_t r = 0; line.plan && r < line.plan->requests.size() && r < line.request_times.size();
             ++r)
            requests.push_back(request_json(project.lines[i], line.plan->requests[r], line.requests[r],
                                            line.request_times[r]));
        object.set("requests", std::move(requests));
        lines.push_back(std::move(object));
    }
    auto object = file::Json::object();
    object.set("lines", std::move(lines));
    return object;
}

file::Json course_json(const model::Line& line, const plan::LinePlan& planned) {
    constexpr std::size_t kMostBars = 1000;  // about 25 bytes each
    auto course = plan::timeline(line, planned, plan::round_window(planned).length, kMostBars);
    if (course.cut) course.window = course.bars.back().end();
    auto bars = file::Json::array();
    for (const auto& bar : course.bars)
        bars.push_back(file::Json(file::Json::Array{bar.request, report::microseconds(bar.start),
                                                    report::microseconds(bar.end()), bar.late}));
    auto object = file::Json::object();
    object.set("length_ms", report::milliseconds(course.window));
    object.set("bars", std::move(bars));
    return object;
}

}  // namespace takt::web
