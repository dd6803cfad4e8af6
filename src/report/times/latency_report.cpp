#include "takt/report/times/latency_report.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "takt/capture/bound.hpp"
#include "takt/model/scalar.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/text_table.hpp"
#include "takt/report/times/history_time.hpp"
#include "times/latency_parts.hpp"

namespace takt::report {
namespace {

using capture::Series;
using capture::SeriesKey;

constexpr std::size_t kMostSeriesRows = 50;
constexpr double kLargeShare = 0.1;  // above it a bound is given in percent

std::string ip_text(const IpAddress& address) {
    char text[INET6_ADDRSTRLEN] = {};
    if (address.is_ipv4())
        return fmt::format("{}.{}.{}.{}", address.bytes[12], address.bytes[13], address.bytes[14],
                           address.bytes[15]);
    ::inet_ntop(AF_INET6, address.bytes.data(), text, sizeof text);
    return text;
}

std::string rate_text(const client::Rate& rate) {
    return fmt::format("{}/{}", rate.requests, rate.per == std::chrono::minutes(1) ? "min" : "s");
}

/// Milliseconds down to a microsecond: "0.149".
std::string plain_milliseconds_text(Duration time) {
    return fmt::format("{:.3f}", milliseconds(time));
}

/// Prints rows of series.
class SeriesRows {
public:
    SeriesRows(const Texts& texts, const capture::LatencyReport& report) : texts_(texts), report_(report) {}

    [[nodiscard]] std::string counts(std::size_t columns) const {
        using enum TextTable::Align;
        TextTable table({right, left, left, right, right, right, right, left, right, right, right});
        table.add({word("number"), word("client"), word("server"), word("unit"), word("function"),
                   word("requests"), word("answered"), word("exceptions"), word("unanswered"), word("late"),
                   word("repeated")});
        for_each_row([&](const std::string& number, const SeriesKey& key, const Series& series) {
            const auto exceptions = exceptions_text(series);
            table.add({number, client_text(key, grouping()), server_text(key, grouping()),
                       is_total(key) || !grouping().unit ? "" : std::to_string(key.unit),
                       is_total(key) || !grouping().function ? "" : fmt::format("0x{:02X}", key.function),
                       count(series.requests), count(series.answered), exceptions.empty() ? "0" : exceptions,
                       count(series.unanswered), count(series.late), count(series.retransmissions)});
        });
        return table.render("", columns);
    }

    [[nodiscard]] std::string times(std::size_t columns) const {
        using enum TextTable::Align;
        TextTable table(std::vector(4 + kPercentiles.size() + 3, right));
        auto heading = heading_of_times(word("number"));
        for (const char* name : {"period", "jitter", "jitter_max"}) heading.push_back(word(name));
        table.add(heading);
        for_each_row([&](const std::string& number, const SeriesKey&, const Series& series) {
            table.add(times_of(number, series));
        });
        return table.render("", columns);
    }

    /// One row of times without a series.
    [[nodiscard]] std::string times_of(const capture::MeasuredTimes& times, std::size_t columns) const {
        TextTable table(std::vector(3 + kPercentiles.size(), TextTable::Align::right));
        auto heading = heading_of_times("");
        heading.erase(heading.begin());
        table.add(heading);
        std::vector<std::string> cells;
        add_times(cells, times);
        table.add(cells);
        return table.render("", columns);
    }

private:
    [[nodiscard]] std::string word(std::string_view name) const {
        return texts_("app.latency." + std::string(name));
    }
    [[nodiscard]] std::vector<std::string> heading_of_times(const std::string& first) const {
        std::vector<std::string> heading{first, word("min"), word("mean")};
        for (const auto& percentile : kPercentiles) heading.emplace_back(percentile.name);
        heading.push_back(word("max"));
        return heading;
    }
    [[nodiscard]] std::string count(std::uint64_t number) const {
        return grouped_number(number, texts_.language());
    }
    [[nodiscard]] const capture::Grouping& grouping() const { return report_.config().grouping; }
    [[nodiscard]] bool is_total(const SeriesKey& key) const { return &key == &kTotal; }

    static void add_times(std::vector<std::string>& cells, const capture::MeasuredTimes& times) {
        if (times.count() == 0) {
            cells.insert(cells.end(), 3 + kPercentiles.size(), "–");
            return;
        }
        cells.push_back(plain_milliseconds_text(times.min()));
        cells.push_back(plain_milliseconds_text(times.mean()));
        for (const auto& [name, percent] : kPercentiles)
            cells.push_back(plain_milliseconds_text(times.percentile(percent)));
        cells.push_back(plain_milliseconds_text(times.max()));
    }

    [[nodiscard]] static std::vector<std::string> times_of(const std::string& number, const Series& series) {
        std::vector<std::string> cells{number};
        add_times(cells, series.times);
        cells.emplace_back(series.intervals == 0 ? "–" : plain_milliseconds_text(series.mean_interval()));
        cells.emplace_back(series.jitter.count() == 0 ? "–" : plain_milliseconds_text(series.jitter.mean()));
        cells.emplace_back(series.jitter.count() == 0 ? "–" : plain_milliseconds_text(series.jitter.max()));
        return cells;
    }

    template <class Row>
    void for_each_row(const Row& row) const {
        const auto& series = report_.series();
        for (std::size_t i = 0; i < std::min(series.size(), kMostSeriesRows); ++i)
            row(std::to_string(i + 1), series[i].first, *series[i].second);
        if (report_.others().requests > 0) row(word("others"), kTotal, report_.others());
        if (series.size() != 1) row(word("total"), kTotal, report_.total());
    }

    inline static const SeriesKey kTotal{};
    const Texts& texts_;
    const capture::LatencyReport& report_;
};

std::string load_heading_text(const Texts& texts, const LatencyRun& run) {
    const auto& [options, counts] = *run.load;
    const auto& request = options.request.shape();
    const auto rate = options.rate ? texts("app.latency.load.rate", {{"rate", rate_text(*options.rate)}})
                                   : texts("app.latency.load.fast");
    return texts("app.latency.load.heading",
                 {{"target", run.file},
                  {"unit", std::to_string(options.target.unit)},
                  {"function", fmt::format("0x{:02X}", request.function)},
                  {"first", std::to_string(request.start.value)},
                  {"last", std::to_string(request.start.value + request.quantity - 1)},
                  {"connections", std::to_string(options.connections)},
                  {"in_flight", std::to_string(options.in_flight)},
                  {"rate", rate},
                  {"requests", grouped_number(counts.sent, texts.language())},
                  {"seconds", fmt::format("{:.1f}", milliseconds(counts.elapsed) / 1000)},
                  {"per_second", fmt::format("{:.1f}", sent_per_second(counts))},
                  {"from", short_time_text(run.packets.first_ns, INT64_MIN)},
                  {"to", short_time_text(run.packets.last_ns, run.packets.first_ns)}}) +
           '\n';
}

std::string latency_heading_text(const Texts& texts, const LatencyRun& run) {
    if (run.load) return load_heading_text(texts, run);
    const auto& packets = run.packets;
    const auto requests = grouped_number(run.report.total().requests, texts.language());
    const auto count = grouped_number(packets.packets, texts.language());
    if (packets.packets == packets.untimed)
        return texts("app.latency.heading_untimed",
                     {{"file", run.file}, {"packets", count}, {"requests", requests}}) +
               '\n';
    return texts("app.latency.heading", {{"file", run.file},
                                         {"packets", count},
                                         {"requests", requests},
                                         {"from", short_time_text(packets.first_ns, INT64_MIN)},
                                         {"to", short_time_text(packets.last_ns, packets.first_ns)}}) +
           '\n';
}

/// Of a load: which request, and when it was due or sent.
std::string slowest_requests_text(const Texts& texts, const LatencyRun& run, std::size_t columns) {
    using enum TextTable::Align;
    TextTable table({right, right, left});
    table.add({texts("app.latency.number"), texts("app.latency.time"), texts("app.latency.at")});
    for (const auto& exchange : run.report.slowest())
        table.add({std::to_string(exchange.request.packet.number), plain_milliseconds_text(exchange.time()),
                   short_time_text(exchange.request.packet.time_ns, run.packets.first_ns)});
    return texts("app.latency.load.slowest") + '\n' + table.render("", columns);
}

std::string slowest_text(const Texts& texts, const LatencyRun& run, std::size_t columns) {
    const auto slowest = run.report.slowest();
    if (slowest.empty()) return {};
    if (run.load) return slowest_requests_text(texts, run, columns);
    using enum TextTable::Align;
    TextTable table({right, right, right, left, left, right, right});
    const auto word = [&](const char* name) { return texts(std::string("app.latency.") + name); };
    table.add({word("request_packet"), word("response_packet"), word("time"), word("client"), word("server"),
               word("unit"), word("function")});
    for (const auto& exchange : slowest) {
        const auto& route = exchange.request.route;
        table.add(
            {std::to_string(exchange.request.packet.number), std::to_string(exchange.response.packet.number),
             plain_milliseconds_text(exchange.time()), route.serial ? "" : endpoint_text(route.client),
             route.serial ? fmt::format("serial {}", route.interface) : endpoint_text(route.server),
             std::to_string(exchange.request.unit), fmt::format("0x{:02X}", exchange.request.function)});
    }
    return texts("app.latency.slowest") + '\n' + table.render("", columns);
}

std::vector<std::pair<std::string, std::uint64_t>> load_notes(const LatencyRun& run) {
    if (!run.load) return {};
    const auto& counts = run.load->counts;
    return {{"app.latency.load.note.unsent", counts.unsent},
            {"app.latency.load.note.timed_out", counts.timed_out},
            {"app.latency.load.note.wrong", counts.wrong},
            {"app.latency.load.note.unexpected", counts.unexpected},
            {"app.latency.load.note.lost", counts.lost},
            {"app.latency.load.note.different", counts.different},
            {"app.latency.load.note.disconnections", counts.disconnections}};
}

/// One line for each count that is not zero.
std::string notes_text(const Texts& texts, const LatencyRun& run) {
    const auto& [packets, tcp, serial] = std::tie(run.packets, run.tcp, run.serial);
    const std::pair<const char*, std::uint64_t> notes[] = {
        {"open", run.report.total().open},
        {"broadcasts", run.report.total().broadcasts},
        {"unmatched", tcp.unmatched + serial.unmatched},
        {"repeated_ids", tcp.repeated_ids},
        {"retransmissions", tcp.streams.retransmissions},
        {"duplicates", tcp.streams.duplicates},
        {"out_of_order", tcp.streams.out_of_order},
        {"gaps", tcp.streams.gaps},
        {"missing_bytes", tcp.streams.missing_bytes},
        {"resynchronisations", tcp.resynchronisations},
        {"skipped_bytes", tcp.skipped_bytes},
        {"damaged", serial.damaged},
        {"line_errors", serial.line_errors},
        {"serial_framing", tcp.serial_framing},
        {"foreign", tcp.foreign},
        {"evicted", tcp.evicted},
        {"fragments", packets.lost_fragments},
        {"other", run.report.total().requests == 0 ? packets.other : 0},
        {"cut", packets.cut},
        {"malformed", packets.malformed},
        {"dropped", packets.dropped},
        {"untimed", packets.untimed},
        {"backwards", packets.backwards}};
    std::string text;
    const auto add = [&](const std::string& line) {
        text += (text.empty() ? texts("app.latency.notes") + '\n' : "") + "  " + line + '\n';
    };
    for (const auto& [name, count] : notes)
        if (count > 0)
            add(texts(std::string("app.latency.note.") + name,
                      {{"count", grouped_number(count, texts.language())}}));
    for (const auto& [name, count] : load_notes(run))
        if (count > 0) add(texts(name, {{"count", grouped_number(count, texts.language())}}));
    if (packets.other_link > 0)
        add(texts("app.latency.note.other_link",
                  {{"count", grouped_number(packets.other_link, texts.language())},
                   {"type", std::to_string(packets.first_other_link)}}));
    return text;
}

}  // namespace

std::string endpoint_text(const capture::Endpoint& endpoint) {
    auto address = ip_text(endpoint.address);
    if (endpoint.port == 0) return address;
    return endpoint.address.is_ipv4() ? fmt::format("{}:{}", address, endpoint.port)
                                      : fmt::format("[{}]:{}", address, endpoint.port);
}

std::string grouped_number(std::uint64_t number, text::Language language) {
    const std::string_view separator = language == text::Language::english ? "," : "\u00A0";
    std::string digits = std::to_string(number);
    for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, separator);
    return digits;
}

std::string client_text(const SeriesKey& key, const capture::Grouping& grouping) {
    if (key == SeriesKey{} || key.serial || !grouping.client) return {};
    return endpoint_text({key.client, 0});
}

std::string server_text(const SeriesKey& key, const capture::Grouping& grouping) {
    if (key == SeriesKey{} || !grouping.server) return {};
    return key.serial ? fmt::format("serial {}", key.interface) : endpoint_text(key.server);
}

std::string exceptions_text(const Series& series) {
    std::string text;
    for (const auto& [code, count] : series.exceptions)
        text += fmt::format("{}{}:{}", text.empty() ? "" : " ", code, count);
    return text;
}

double sent_per_second(const client::LoadCounts& counts) {
    const double seconds = milliseconds(counts.elapsed) / 1000;
    return seconds > 0 ? static_cast<double>(counts.sent) / seconds : 0;
}

std::optional<model::MeasuredRoundTrip> round_trip_of(const LatencyRun& run) {
    if (!run.load || run.file.find(":///") != std::string::npos) return std::nullopt;
    const auto& [options, counts] = *run.load;
    const auto& times = counts.from_sending;
    const bool complete = counts.timed_out + counts.wrong + counts.lost == 0;
    if (options.connections > 1 || !complete || times.count() < model::MeasuredTimes::kEnough)
        return std::nullopt;
    const auto whole = [](Duration time) { return std::chrono::ceil<std::chrono::microseconds>(time); };
    return model::MeasuredRoundTrip{.longest = whole(times.max()),
                                    .usual = whole(std::min(times.percentile(99.9), times.max())),
                                    .exchanges = times.count(),
                                    .in_flight = static_cast<std::uint16_t>(options.in_flight)};
}

LatencyVerdict latency_verdict(const capture::LatencyReport& report) {
    const auto& total = report.total();
    return {total.decided(), total.exceeded, capture::upper_bound(total.exceeded, total.decided())};
}

std::string latency_verdict_text(const Texts& texts, const capture::LatencyReport& report) {
    const auto verdict = latency_verdict(report);
    const auto language = texts.language();
    const std::string limit = texts.exact(report.config().limit.value_or(Duration::zero()));
    if (verdict.exchanges == 0) return texts("app.latency.undecided", {{"limit", limit}});
    auto text = texts(verdict.kept() ? "app.latency.kept" : "app.latency.exceeded",
                      {{"limit", limit},
                       {"count", grouped_number(verdict.exchanges, language)},
                       {"exceeded", grouped_number(verdict.exceeded, language)}});
    if (verdict.bound >= 1) return text;
    if (verdict.bound > kLargeShare)
        return text + ' ' +
               texts("app.latency.confidence.percent",
                     {{"limit", limit}, {"percent", fmt::format("{:.0f}", std::ceil(verdict.bound * 100))}});
    return text + ' ' +
           texts("app.latency.confidence.one_in",
                 {{"limit", limit}, {"one_in", grouped_number(capture::one_in(verdict.bound), language)}});
}

std::string latency_text(const Texts& texts, const LatencyRun& run, std::size_t columns) {
    const auto& report = run.report;
    std::string text = latency_heading_text(texts, run);
    const SeriesRows rows(texts, report);
    if (report.total().requests > 0) {
        text += '\n' + rows.counts(columns);
        if (report.series().size() > kMostSeriesRows)
            text += texts("app.latency.more",
                          {{"count", std::to_string(report.series().size() - kMostSeriesRows)}}) +
                    '\n';
        const bool has_rate = run.load && run.load->options.rate;
        text += '\n' + texts(has_rate ? "app.latency.load.times" : "app.latency.times") + '\n' +
                rows.times(columns);
        if (has_rate)
            text += '\n' + texts("app.latency.load.from_sending") + '\n' +
                    rows.times_of(run.load->counts.from_sending, columns);
        else if (run.load)
            text += '\n' + texts("app.latency.load.closed") + '\n';
    }
    if (const auto slowest = slowest_text(texts, run, columns); !slowest.empty()) text += '\n' + slowest;
    if (const auto notes = notes_text(texts, run); !notes.empty()) text += '\n' + notes;
    if (const auto round_trip = round_trip_of(run))
        text +=
            '\n' +
            texts(
                "app.latency.load.round_trip",
                {{"line", fmt::format("round_trip: {{longest: {}, usual: {}, exchanges: {}, "
                                      "in_flight: {}}}",
                                      model::to_text(round_trip->longest), model::to_text(round_trip->usual),
                                      round_trip->exchanges, round_trip->in_flight)}}) +
            '\n';
    if (report.config().limit) text += '\n' + latency_verdict_text(texts, report) + '\n';
    return text;
}

std::string capture_error_text(const Texts& texts, const std::string& file,
                               const capture::CaptureError& error) {
    const bool is_bytes = error.fault == capture::CaptureFault::not_a_capture ||
                          error.fault == capture::CaptureFault::compressed ||
                          error.fault == capture::CaptureFault::byte_order;
    return texts("app.latency.fault." + std::string(name(error.fault)),
                 {{"file", file},
                  {"offset", std::to_string(error.offset)},
                  {"packet", std::to_string(error.packet)},
                  {"value", is_bytes ? fmt::format("{:08X}", error.value) : std::to_string(error.value)},
                  {"allowed", std::to_string(error.allowed)}});
}

}  // namespace takt::report
