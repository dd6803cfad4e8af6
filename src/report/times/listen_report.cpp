#include "takt/report/times/listen_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "takt/model/target_url.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/text_table.hpp"
#include "takt/text/frame_text.hpp"
#include "takt/wire/frame_words.hpp"

namespace takt::report {
namespace {

using capture::Exchange;
using capture::Outcome;
using capture::Poll;
using file::Json;

constexpr std::size_t kMostBytesShown = 32;
constexpr std::size_t kMostPollsShown = 200;  // rows of the table

std::string with_device_name(const HeardNames& names, std::uint8_t unit, const std::string& words) {
    const auto* const device = names.device(unit);
    return device != nullptr ? device->name + ": " + words : words;
}

std::string words_of(const Exchange& exchange) {
    const UnitId unit{exchange.request.unit};
    const auto pdu = exchange.request.pdu.span();
    if (exchange.response.empty()) return wire::describe_request(unit, pdu);
    const auto request = wire::decode_request(pdu);
    return wire::describe_response(unit, exchange.response, request ? &*request : nullptr);
}

/// The outcome of an exchange and its peculiarities, behind its words.
std::string exchange_remarks(const Texts& texts, const Exchange& exchange) {
    std::string text;
    const auto add = [&](const std::string& remark) { text += "; " + remark; };
    switch (exchange.outcome) {
        case Outcome::answered:
        case Outcome::exception: add(texts.duration(exchange.response_time)); break;
        case Outcome::unanswered: add(texts("app.listen.no_response")); break;
        case Outcome::broadcast: add(texts("app.listen.broadcast")); break;
        case Outcome::open: add(texts("app.listen.open")); break;
    }
    if (exchange.request.overlaps) add(texts("app.listen.overlaps"));
    if (exchange.request.repeats) add(texts("app.listen.repeats"));
    return text;
}

std::string bytes_text(Bytes bytes) {
    auto text = wire::hex(bytes.first(std::min(bytes.size(), kMostBytesShown)));
    return bytes.size() > kMostBytesShown ? text + " …" : text;
}

// ---- the summary

std::string poll_text(const capture::PollKey& key) {
    auto text = function_text(wire::Function{key.function});
    if (key.quantity == 0) return text;
    text += fmt::format(" {}", key.start);
    return key.quantity > 1 ? text + fmt::format("..{}", key.start + key.quantity - 1) : text;
}

std::string heard_period_text(const Texts& texts, const Poll::Period& period) {
    if (period.median == Duration::zero()) return {};
    return fmt::format("{} ({} – {})", texts.duration(period.median), texts.duration(period.least),
                       texts.duration(period.greatest));
}

std::string count_text(std::uint64_t count) {
    return count == 0 ? std::string() : std::to_string(count);
}

std::string time_cell(const capture::MeasuredTimes& times, Duration time) {
    return times.count() == 0 ? std::string() : fmt::format("{:.2f}", milliseconds(time));
}

std::string exception_counts_text(const std::map<std::uint8_t, std::uint64_t>& exceptions) {
    std::string text;
    for (const auto& [code, count] : exceptions)
        text += fmt::format("{}{}×{}", text.empty() ? "" : " ", code, count);
    return text;
}

std::string device_state(const Texts& texts, const capture::HeardDevice& device) {
    if (device.requests == 0) return texts("app.listen.not_asked");
    if (!device.silent()) return {};
    return texts(device.answered == 0 ? "app.listen.never_answers" : "app.listen.silent");
}

std::string devices_table(const Texts& texts, const ListenRun& run, std::size_t most) {
    using enum TextTable::Align;
    TextTable table({right, left, right, right, left, right, right, right, right, right, left});
    table.add({texts("app.latency.unit"), texts("app.listen.device"), texts("app.latency.requests"),
               texts("app.latency.answered"), texts("app.latency.exceptions"),
               texts("app.latency.unanswered"), texts("app.latency.min"), "p50", "p99",
               texts("app.latency.max"), ""});
    for (const auto& [unit, device] : run.statistics.devices()) {
        const auto* const known = run.names.device(unit);
        const auto& times = device.times;
        table.add({std::to_string(unit), known != nullptr ? known->name : std::string(),
                   std::to_string(device.requests), std::to_string(device.answered),
                   exception_counts_text(device.exceptions), count_text(device.unanswered),
                   time_cell(times, times.min()), time_cell(times, times.percentile(50)),
                   time_cell(times, times.percentile(99)), time_cell(times, times.max()),
                   device_state(texts, device)});
    }
    return table.render("  ", most);
}

/// The number of the master of each poll, from 1 on.
using MasterNumbers = std::map<std::pair<std::uint8_t, std::size_t>, std::size_t>;

MasterNumbers master_numbers(const std::vector<capture::HeardMaster>& masters) {
    MasterNumbers numbers;
    for (std::size_t i = 0; i < masters.size(); ++i)
        for (const auto& poll : masters[i].polls) numbers[{poll.unit, poll.poll}] = i + 1;
    return numbers;
}

std::string polls_table(const Texts& texts, const ListenRun& run, const MasterNumbers& numbers,
                        std::size_t most) {
    using enum TextTable::Align;
    TextTable table({right, left, right, left, right, right, right, right});
    table.add({texts("app.latency.unit"), texts("app.listen.request"), texts("app.listen.master"),
               texts("app.latency.period"), texts("app.latency.requests"), texts("app.latency.answered"),
               texts("app.latency.unanswered"), texts("app.latency.repeated")});
    std::size_t shown = 0;
    std::size_t hidden = 0;
    for (const auto& [unit, device] : run.statistics.devices()) {
        for (std::size_t i = 0; i < device.polls.size(); ++i) {
            if (++shown > kMostPollsShown) {
                ++hidden;
                continue;
            }
            const auto& poll = device.polls[i];
            const auto number = numbers.find({unit, i});
            table.add({std::to_string(unit), poll_text(poll.key),
                       number != numbers.end() ? std::to_string(number->second) : std::string(),
                       heard_period_text(texts, poll.period()), std::to_string(poll.requests),
                       std::to_string(poll.normal + poll.exceptions), count_text(poll.unanswered),
                       count_text(poll.repeats)});
        }
        hidden += device.other_polls;
    }
    auto text = table.render("  ", most);
    if (hidden > 0) text += "  " + texts("app.listen.more_polls", {{"count", std::to_string(hidden)}}) + '\n';
    return text;
}

std::string masters_text(const Texts& texts, const std::vector<capture::HeardMaster>& masters) {
    std::string text;
    for (std::size_t i = 0; i < masters.size(); ++i) {
        const auto& master = masters[i];
        text += "  " +
                texts("app.listen.master_line", {{"number", std::to_string(i + 1)},
                                                 {"cycle", heard_period_text(texts, master.cycle)},
                                                 {"polls", std::to_string(master.polls.size())},
                                                 {"requests", std::to_string(master.requests)}}) +
                '\n';
    }
    return text;
}

double busy_share(const capture::LineCounts& counts) {
    const auto length = counts.last - counts.first;
    return length <= Duration::zero() ? 0 : std::min(1.0, milliseconds(counts.busy) / milliseconds(length));
}

std::string line_head(const Texts& texts, const ListenRun& run) {
    const auto& counts = run.statistics.counts();
    std::string text = texts(
        "app.listen.heading",
        {{"port", run.one_of_several ? texts("app.listen.of_line", {{"file", run.port}, {"line", run.line}})
                                     : run.port},
         {"setting", line_setting_text(run.connection, run.has_settings)},
         {"time", texts.duration(counts.last - counts.first)}});
    if (run.has_settings)
        text += ", " + texts("app.listen.busy", {{"share", percent_text(busy_share(counts))}});
    text += '\n' + texts("app.listen.counts", {{"requests", std::to_string(counts.requests)},
                                               {"answered", std::to_string(counts.responses)},
                                               {"unanswered", std::to_string(counts.unanswered)},
                                               {"broadcasts", std::to_string(counts.broadcasts)},
                                               {"open", std::to_string(counts.open)}});
    text += '\n' + texts("app.listen.faults", {{"damaged", std::to_string(counts.damaged)},
                                               {"bytes", std::to_string(counts.damaged_bytes)},
                                               {"strays", std::to_string(counts.strays)},
                                               {"overlaps", std::to_string(counts.overlaps)},
                                               {"characters", std::to_string(run.faulty_characters)}});
    return text + '\n';
}

}  // namespace

std::string line_setting_text(const model::Line& connection, bool has_settings) {
    const std::string framing = connection.framing == wire::Framing::ascii ? "ASCII" : "RTU";
    return has_settings ? model::settings_text(connection) + ", " + framing : framing;
}

std::string exchange_line(const Texts& texts, const HeardNames& names, const std::string& time,
                          const Exchange& exchange) {
    auto line = time + "  " +
                with_device_name(names, exchange.request.unit,
                                 text::frame_text(texts.language(), words_of(exchange))) +
                exchange_remarks(texts, exchange);
    std::string separator = "; ";
    for (const auto& value : names.values(exchange)) {
        line += separator + value.variable->name + " = " + value.text;
        separator = ", ";
    }
    return line;
}

std::string stray_line(const Texts& texts, const HeardNames& names, const std::string& time,
                       const capture::LineFrame& frame) {
    const auto words =
        text::frame_text(texts.language(), wire::describe_response(UnitId{frame.unit}, frame.pdu));
    return time + "  " + with_device_name(names, frame.unit, words) + "; " + texts("app.listen.stray");
}

std::string damaged_line(const Texts& texts, const std::string& time, const capture::DamagedBytes& damaged) {
    return time + "  " +
           texts("app.listen.damaged",
                 {{"count", std::to_string(damaged.bytes.size())}, {"bytes", bytes_text(damaged.bytes)}});
}

std::string listen_summary(const Texts& texts, const ListenRun& run, std::size_t most) {
    auto text = line_head(texts, run);
    if (run.statistics.devices().empty()) return text;
    text += '\n' + texts("app.listen.devices") + '\n' + devices_table(texts, run, most);
    const auto masters = run.statistics.masters();
    if (!masters.empty()) text += '\n' + texts("app.listen.masters") + '\n' + masters_text(texts, masters);
    return text + '\n' + texts("app.listen.polls") + '\n' +
           polls_table(texts, run, master_numbers(masters), most);
}

}  // namespace takt::report
