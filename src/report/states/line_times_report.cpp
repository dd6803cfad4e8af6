#include "takt/report/states/line_times_report.hpp"

#include <algorithm>
#include <utility>

#include "takt/report/drawing/formatting.hpp"

namespace takt::report {
namespace {

constexpr std::size_t kShown = 8;  // requests

file::Json part_json(const poll::HistogramSnapshot& times) {
    if (times.count == 0) return {};
    auto object = file::Json::object();
    object.set("count", times.count);
    object.set("p50_us", whole_microseconds(times.p50));
    object.set("p99_us", whole_microseconds(times.p99));
    object.set("longest_us", whole_microseconds(times.longest));
    object.set("histogram", histogram_json(times));
    return object;
}

/// Of a histogram in microseconds, whose first one includes zero.
std::string within_text(const Texts& texts, Duration percentile, Duration longest) {
    return texts.duration(
        std::min<Duration>(std::max<Duration>(percentile, std::chrono::microseconds(1)), longest));
}

}  // namespace

std::string line_times_text(const Texts& texts, const poll::LineTimes& times) {
    std::string text;
    const std::pair<const char*, const poll::HistogramSnapshot&> parts[] = {
        {"app.times.wire", times.wire},
        {"app.times.turnaround", times.turnaround},
        {"app.times.host", times.host}};
    for (const auto& [code, part] : parts)
        if (part.count > 0)
            text += "  " +
                    texts("app.times.part", {{"part", texts(code)},
                                             {"p50", within_text(texts, part.p50, part.longest)},
                                             {"p99", within_text(texts, part.p99, part.longest)},
                                             {"longest", texts.duration(part.longest)}}) +
                    '\n';
    return text;
}

file::Json line_times_json(const poll::LineTimes& times) {
    auto object = file::Json::object();
    object.set("wire", part_json(times.wire));
    object.set("turnaround", part_json(times.turnaround));
    object.set("host", part_json(times.host));
    return object;
}

file::Json histogram_json(const poll::HistogramSnapshot& times) {
    auto list = file::Json::array();
    for (const auto& bucket : times.buckets) {
        auto pair = file::Json::array();
        pair.push_back(bucket.upper_us);
        pair.push_back(bucket.count);
        list.push_back(std::move(pair));
    }
    return list;
}

std::string broken_bounds_text(const Texts& texts, const host::Snapshot& snapshot, std::size_t index) {
    const auto& line = snapshot.lines[index];
    const auto& devices = snapshot.configuration->project().lines[index].devices;
    std::string text;
    std::size_t shown = 0;
    std::size_t left_out = 0;
    for (std::size_t r = 0; r < line.requests.size(); ++r) {
        const auto& measured = line.requests[r];
        if (measured.over_cost == 0 && measured.late_refreshes == 0) continue;
        if (shown == kShown) {
            ++left_out;
            continue;
        }
        ++shown;
        const auto& request = line.plan->requests[r];
        text += "  " +
                texts("app.broken_bounds", {{"device", devices[request.device].name},
                                            {"request", request_text(request)},
                                            {"over", std::to_string(measured.over_cost)},
                                            {"count", std::to_string(measured.counters.time.count())},
                                            {"late", std::to_string(measured.late_refreshes)}}) +
                '\n';
    }
    if (left_out > 0)
        text += "  " + texts("app.broken_bounds.more", {{"count", std::to_string(left_out)}}) + '\n';
    return text;
}

}  // namespace takt::report
