// The object of `takt latency --json` (docs/commands/latency.md). A time that was not measured is null.
#include <fmt/format.h>

#include "takt/capture/bound.hpp"
#include "takt/model/scalar.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/times/history_time.hpp"
#include "takt/report/times/latency_report.hpp"
#include "times/latency_parts.hpp"

namespace takt::report {
namespace {

using capture::Series;
using capture::SeriesKey;
using file::Json;

void set_times(Json& object, const capture::MeasuredTimes& times) {
    const auto set = [&](std::string_view name, Duration time) {
        object.set(std::string(name) + "_ms", times.count() == 0 ? Json() : Json(milliseconds(time)));
    };
    set("min", times.min());
    set("mean", times.mean());
    for (const auto& [name, percent] : kPercentiles) set(name, times.percentile(percent));
    set("max", times.max());
}

void set_series(Json& object, const Series& series, bool limit) {
    auto exceptions = Json::object();
    for (const auto& [code, count] : series.exceptions) exceptions.set(std::to_string(code), count);
    object.set("requests", series.requests);
    object.set("answered", series.answered);
    object.set("exceptions", std::move(exceptions));
    object.set("unanswered", series.unanswered);
    object.set("open", series.open);
    object.set("broadcasts", series.broadcasts);
    object.set("late", series.late);
    if (limit) object.set("exceeded", series.exceeded);
    object.set("retransmissions", series.retransmissions);
    set_times(object, series.times);
    object.set("period_ms", series.intervals == 0 ? Json() : Json(milliseconds(series.mean_interval())));
    auto jitter = Json::object();
    set_times(jitter, series.jitter);
    object.set("jitter", series.jitter.count() == 0 ? Json() : std::move(jitter));
}

Json series_json(const SeriesKey& key, const Series& series, const capture::LatencyConfig& config) {
    auto object = Json::object();
    const auto& grouping = config.grouping;
    if (grouping.client) object.set("client", key.serial ? Json() : Json(client_text(key, grouping)));
    if (grouping.server) object.set("server", server_text(key, grouping));
    if (grouping.unit) object.set("unit", key.unit);
    if (grouping.function) object.set("function", key.function);
    set_series(object, series, config.limit.has_value());
    return object;
}

/// Of a load: `at` is when the request was due, or sent where it has no rate.
Json slow_request_json(const capture::SlowExchange& exchange) {
    auto object = Json::object();
    object.set("time_ms", milliseconds(exchange.time()));
    object.set("request", exchange.request.packet.number);
    object.set("at", utc_time_text(exchange.request.packet.time_ns));
    object.set("exception", exchange.response.exception == 0 ? Json() : Json(exchange.response.exception));
    return object;
}

Json slow_json(const capture::SlowExchange& exchange) {
    auto object = Json::object();
    const auto& [request, response] = std::tie(exchange.request, exchange.response);
    object.set("time_ms", milliseconds(exchange.time()));
    object.set("request_packet", request.packet.number);
    object.set("response_packet", response.packet.number);
    object.set("at", utc_time_text(request.packet.time_ns));
    object.set("client", request.route.serial ? Json() : Json(endpoint_text(request.route.client)));
    object.set("server", request.route.serial ? Json(fmt::format("serial {}", request.route.interface))
                                              : Json(endpoint_text(request.route.server)));
    object.set("transaction", request.transaction);
    object.set("unit", request.unit);
    object.set("function", request.function);
    object.set("exception", response.exception == 0 ? Json() : Json(response.exception));
    object.set("retransmissions", response.retransmissions);
    return object;
}

Json block_histogram_json(const capture::BlockHistogram& histogram) {
    auto list = Json::array();
    for (std::size_t i = 0; i < capture::BlockHistogram::kBuckets; ++i) {
        const auto bucket = histogram.bucket(i);
        if (bucket.count == 0) continue;
        auto object = Json::object();
        object.set("from_us", microseconds(bucket.lower));
        object.set("to_us", bucket.upper == Duration::max() ? Json() : Json(microseconds(bucket.upper)));
        object.set("count", bucket.count);
        list.push_back(std::move(object));
    }
    return list;
}

Json time_line_json(const capture::TimeLine& line) {
    auto object = Json::object();
    object.set("begin", utc_time_text(line.begin_ns()));
    object.set("width_ms", static_cast<double>(line.width_ns()) / 1e6);
    auto spans = Json::array();
    for (std::size_t i = 0; i < line.size(); ++i) {
        if (line[i].count == 0) continue;
        auto span = Json::object();
        span.set("index", i);
        span.set("count", line[i].count);
        span.set("min_ms", milliseconds(line[i].min));
        const auto mean_ns = line[i].sum_ns / line[i].count;
        span.set("mean_ms", static_cast<double>(mean_ns) / 1e6);
        span.set("max_ms", milliseconds(line[i].max));
        spans.push_back(std::move(span));
    }
    object.set("spans", std::move(spans));
    return object;
}

Json verdict_json(const Texts& texts, const capture::LatencyReport& report) {
    const auto verdict = latency_verdict(report);
    auto object = Json::object();
    object.set("limit_ms", milliseconds(*report.config().limit));
    object.set("kept", verdict.kept());
    object.set("exchanges", verdict.exchanges);
    object.set("exceeded", verdict.exceeded);
    object.set("confidence", capture::kConfidence);
    object.set("bound", verdict.bound);
    object.set("one_in", capture::one_in(verdict.bound));
    object.set("words", latency_verdict_text(texts, report));
    return object;
}

Json capture_json(const LatencyRun& run) {
    const auto& [packets, tcp, serial] = std::tie(run.packets, run.tcp, run.serial);
    auto object = Json::object();
    const bool timed = packets.packets > packets.untimed;
    object.set("first", timed ? Json(utc_time_text(packets.first_ns)) : Json());
    object.set("last", timed ? Json(utc_time_text(packets.last_ns)) : Json());
    const std::pair<const char*, std::uint64_t> counts[] = {
        {"packets", packets.packets},
        {"tcp_segments", packets.segments},
        {"serial_frames", packets.serial},
        {"other_packets", packets.other},
        {"fragments", packets.fragments},
        {"lost_fragments", packets.lost_fragments},
        {"cut_packets", packets.cut},
        {"malformed_packets", packets.malformed},
        {"unknown_link_packets", packets.other_link},
        {"dropped_packets", packets.dropped},
        {"untimed_packets", packets.untimed},
        {"backwards", packets.backwards},
        {"connections", tcp.connections},
        {"serial_framing_connections", tcp.serial_framing},
        {"foreign_connections", tcp.foreign},
        {"retransmissions", tcp.streams.retransmissions},
        {"duplicates", tcp.streams.duplicates},
        {"out_of_order", tcp.streams.out_of_order},
        {"overlaps", tcp.streams.overlaps},
        {"gaps", tcp.streams.gaps},
        {"missing_bytes", tcp.streams.missing_bytes},
        {"resynchronisations", tcp.resynchronisations},
        {"skipped_bytes", tcp.skipped_bytes},
        {"unmatched_responses", tcp.unmatched + serial.unmatched},
        {"repeated_ids", tcp.repeated_ids},
        {"evicted_connections", tcp.evicted},
        {"damaged_frames", serial.damaged},
        {"line_errors", serial.line_errors}};
    for (const auto& [name, count] : counts) object.set(name, count);
    return object;
}

/// As the project has it.
Json round_trip_json(const std::optional<model::MeasuredRoundTrip>& round_trip) {
    if (!round_trip) return {};
    auto object = Json::object();
    object.set("longest", model::to_text(round_trip->longest));
    object.set("usual", model::to_text(round_trip->usual));
    object.set("exchanges", round_trip->exchanges);
    object.set("in_flight", round_trip->in_flight);
    return object;
}

Json load_json(const LoadRun& load, const std::optional<model::MeasuredRoundTrip>& round_trip) {
    const auto& [options, counts] = load;
    const auto& request = options.request.shape();
    auto object = Json::object();
    object.set("unit", options.target.unit);
    object.set("function", request.function);
    object.set("start", request.start.value);
    object.set("quantity", request.quantity);
    object.set("connections", options.connections);
    object.set("in_flight", options.in_flight);
    const auto per_second = [](const client::Rate& rate) {
        return static_cast<double>(rate.requests) / (milliseconds(rate.per) / 1000);
    };
    object.set("rate_per_s", options.rate ? Json(per_second(*options.rate)) : Json());
    object.set("coordinated_omission", options.rate ? "avoided" : "possible");
    object.set("elapsed_ms", milliseconds(counts.elapsed));
    object.set("sent_per_s", sent_per_second(counts));
    const std::pair<const char*, std::uint64_t> numbers[] = {{"sent", counts.sent},
                                                             {"unsent", counts.unsent},
                                                             {"timed_out", counts.timed_out},
                                                             {"wrong", counts.wrong},
                                                             {"unexpected", counts.unexpected},
                                                             {"lost", counts.lost},
                                                             {"disconnections", counts.disconnections}};
    for (const auto& [name, count] : numbers) object.set(name, count);
    object.set("different", options.same_content ? Json(counts.different) : Json());
    auto times = Json::object();
    set_times(times, counts.from_sending);
    object.set("from_sending", std::move(times));
    object.set("round_trip", round_trip_json(round_trip));
    return object;
}

std::string csv_times(const capture::MeasuredTimes& times) {
    if (times.count() == 0) return std::string(2 + kPercentiles.size(), ',');
    std::string cells = fmt::format("{},{}", milliseconds(times.min()), milliseconds(times.mean()));
    for (const auto& [name, percent] : kPercentiles)
        cells += fmt::format(",{}", milliseconds(times.percentile(percent)));
    return cells + fmt::format(",{}", milliseconds(times.max()));
}

/// @param limit  there is one: the row has how many exceeded it
std::string csv_row(const std::string& key, const Series& s, bool limit) {
    const std::string period = s.intervals == 0 ? "" : fmt::format("{}", milliseconds(s.mean_interval()));
    const std::string jitter = s.jitter.count() == 0 ? ",,"
                                                     : fmt::format("{},{},{}", milliseconds(s.jitter.mean()),
                                                                   milliseconds(s.jitter.percentile(99)),
                                                                   milliseconds(s.jitter.max()));
    return fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n", key, s.requests, s.answered,
                       exceptions_text(s), s.unanswered, s.open, s.broadcasts, s.late,
                       limit ? std::to_string(s.exceeded) : "", s.retransmissions, csv_times(s.times), period,
                       jitter);
}

}  // namespace

Json latency_json(const Texts& texts, const LatencyRun& run) {
    const auto& report = run.report;
    const auto& config = report.config();
    auto object = Json::object();
    object.set(run.load ? "target" : "file", run.file);
    if (run.load)
        object.set("load", load_json(*run.load, round_trip_of(run)));
    else
        object.set("capture", capture_json(run));
    object.set("timeout_ms", milliseconds(config.timeout));
    auto total = Json::object();
    set_series(total, report.total(), config.limit.has_value());
    object.set("total", std::move(total));
    auto series = Json::array();
    for (const auto& [key, each] : report.series()) series.push_back(series_json(key, *each, config));
    object.set("series", std::move(series));
    if (report.others().requests > 0) {
        auto others = Json::object();
        set_series(others, report.others(), config.limit.has_value());
        object.set("others", std::move(others));
    }
    auto slowest = Json::array();
    for (const auto& exchange : report.slowest())
        slowest.push_back(run.load ? slow_request_json(exchange) : slow_json(exchange));
    object.set("slowest", std::move(slowest));
    object.set("histogram", block_histogram_json(report.total().times.histogram()));
    object.set("time_line", time_line_json(report.time_line()));
    if (config.limit) object.set("verdict", verdict_json(texts, report));
    return object;
}

std::string latency_csv(const capture::LatencyReport& report) {
    std::string text =
        "client,server,unit,function,requests,answered,exceptions,unanswered,open,broadcasts,late,exceeded,"
        "retransmissions,min_ms,mean_ms";
    for (const auto& percentile : kPercentiles) text += fmt::format(",{}_ms", percentile.name);
    text += ",max_ms,period_ms,jitter_mean_ms,jitter_p99_ms,jitter_max_ms\n";
    const auto& grouping = report.config().grouping;
    const bool limit = report.config().limit.has_value();
    for (const auto& [key, series] : report.series()) {
        text += csv_row(fmt::format("{},{},{},{}", client_text(key, grouping), server_text(key, grouping),
                                    grouping.unit ? std::to_string(key.unit) : "",
                                    grouping.function ? std::to_string(key.function) : ""),
                        *series, limit);
    }
    if (report.others().requests > 0) text += csv_row("others,,,", report.others(), limit);
    return text + csv_row("total,,,", report.total(), limit);
}

std::string latency_histogram(const capture::LatencyReport& report) {
    std::string text = "# Histogram\n";
    const auto& counts = report.microseconds();
    for (std::size_t i = 0; i < counts.size(); ++i) text += fmt::format("{:06} {:06}\n", i, counts[i]);
    const auto& times = report.total().times;
    const auto whole = [](Duration time) { return time.count() / 1000; };
    return text +
           fmt::format(
               "# Total: {:09}\n# Min Latencies: {:05}\n# Avg Latencies: {:05}\n# Max Latencies: {:05}\n"
               "# Histogram Overflows: {:05}\n",
               times.count() - report.overflows(), whole(times.min()), whole(times.mean()),
               whole(times.max()), report.overflows());
}

}  // namespace takt::report
