#include "takt/report/states/watch_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <utility>

#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/text_table.hpp"
#include "takt/report/drawing/value_json.hpp"
#include "takt/report/states/state_report.hpp"
#include "takt/text/escape.hpp"
#include "takt/value/text.hpp"

namespace takt::report {
namespace {

using Align = TextTable::Align;

constexpr std::size_t kLeastWatchRows = 8;  // of a screen
constexpr std::size_t kWatchFrameRows =
    3;                                   // of the screen: the heading of the table, the keys, and the cursor
constexpr std::size_t kFailureRows = 4;  // at most

/// The text in lines of at most `width` characters, broken at blanks.
void append_wrapped(std::vector<std::string>& lines, const std::string& text, std::size_t width) {
    std::string line;
    std::istringstream words(text);
    for (std::string word; words >> word;) {
        if (!line.empty() && display_width(line) + 1 + display_width(word) > width)
            lines.push_back(std::exchange(line, "    "));
        line += (line.empty() || line.ends_with(' ') ? "" : " ") + word;
    }
    lines.push_back(fitted(line, width));
}

std::string measured_time_text(const Texts& texts, const bus::TimeStatistics& time, Duration value) {
    return time.count() == 0 ? std::string("–") : texts.duration(value);
}

file::Json milliseconds_json(const bus::TimeStatistics& time, Duration value) {
    return time.count() == 0 ? file::Json() : file::Json(static_cast<double>(value.count()) / 1e6);
}

}  // namespace

void WatchedValue::update(value::Value read, Instant t) {
    changed = !read_at || value != read;
    if (read_at && changed) ++changes;
    value = std::move(read);
    read_at = t;
    trouble.clear();
}

std::string WatchReport::value_text(std::size_t index, const WatchedValue& watched) const {
    if (value::is_empty(watched.value)) return "–";
    const auto type = variables_[index].type;
    if (type == DataType::boolean) return std::get<bool>(watched.value) ? "1" : "0";
    return text::escape_line(value::format(type, false, watched.value));
}

bool WatchReport::is_reported(const WatchedValue& watched) const {
    return watched.read_at && watched.trouble.empty() && (watched.changed || !only_changes_);
}

std::string WatchReport::lines(const std::string& stamp, std::span<const WatchedValue> values) const {
    std::string text;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (is_reported(values[i]))
            text += fmt::format("{} {} = {}\n", stamp, variables_[i].name, value_text(i, values[i]));
    return text;
}

std::string WatchReport::failure_line(const std::string& stamp, const FailedRequest& failed) const {
    const auto& request = *failed.request;
    return fmt::format("{}{}{} {}..{}: {}", stamp, stamp.empty() ? "" : " ", function_text(*request.read),
                       request.start, request.start + request.quantity - 1, texts_.describe(failed.error));
}

file::Json WatchReport::sample_json(const std::string& time, Duration since, std::uint64_t sample,
                                    std::span<const WatchedValue> values,
                                    std::span<const FailedRequest> failures) const {
    file::Json::Array reported;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (!is_reported(values[i])) continue;
        const auto& variable = variables_[i];
        auto entry = file::Json::object();
        entry.set("area", area_word(variable.area));
        entry.set("address", variable.start());
        entry.set("type", name(variable.type));
        entry.set("value", to_json(variable.type, false, values[i].value));
        entry.set("changed", values[i].changed);
        reported.push_back(std::move(entry));
    }
    if (only_changes_ && reported.empty() && failures.empty()) return {};
    auto errors = file::Json::array();
    for (const auto& failed : failures) {
        auto entry = error_json(texts_, failed.error);
        entry.set("function", static_cast<int>(*failed.request->read));
        entry.set("start", failed.request->start);
        entry.set("quantity", failed.request->quantity);
        errors.push_back(std::move(entry));
    }
    auto object = file::Json::object();
    object.set("event", "sample");
    object.set("sample", sample);
    object.set("time", time);
    object.set("time_ms", since / std::chrono::milliseconds(1));
    object.set("values", file::Json(std::move(reported)));
    object.set("errors", std::move(errors));
    return object;
}

std::vector<std::string> WatchReport::table(const Screen& screen, Instant now,
                                            std::span<const WatchedValue> values,
                                            const WatchStatistics& statistics,
                                            std::span<const FailedRequest> failures,
                                            LiveSelection& selection) const {
    const std::size_t width = screen.columns - 1;
    const std::size_t rows = std::max(screen.rows, kLeastWatchRows) - kWatchFrameRows;
    std::vector<std::string> lines{heading(statistics, failures), statistics_text(statistics)};
    std::vector<std::string> below;
    const std::size_t most = std::min(kFailureRows, rows - lines.size() - 1);
    for (const auto& failed : failures) {
        const auto whole = below.size();
        append_wrapped(below, failure_line("", failed), width);
        if (below.size() <= most) continue;
        below.resize(whole == 0 ? most : whole);
        break;
    }
    std::vector<std::size_t> selected;
    for (std::size_t i = 0; i < values.size(); ++i)
        if (is_selected(selection, variables_[i].name) && (!selection.not_good || !values[i].trouble.empty()))
            selected.push_back(i);
    std::ranges::stable_partition(selected, [&](std::size_t i) { return !values[i].trouble.empty(); });
    const auto shown = turn_page(selection, selected.size(), rows - lines.size() - below.size());
    TextTable table({Align::left, Align::right, Align::left, Align::right, Align::right, Align::whole});
    table.add({"", texts_("app.value"), "", texts_("app.age"), texts_("app.watch.changes"), ""});
    for (const auto i : std::span(selected).subspan(selection.first, shown)) {
        const auto& watched = values[i];
        table.add({variables_[i].name, value_text(i, watched),
                   watched.changed && watched.changes > 0 ? "*" : "",
                   watched.read_at ? texts_.duration(now - *watched.read_at) : "",
                   std::to_string(watched.changes), watched.trouble});
    }
    for (auto& line : table.lines(width)) lines.push_back(std::move(line));
    for (auto& line : below) lines.push_back(std::move(line));
    if (auto keys = keys_line(texts_, selection, selected.size(), shown); !keys.empty())
        lines.push_back(std::move(keys));
    return lines;
}

/// The target and how its last sample went.
std::string WatchReport::heading(const WatchStatistics& statistics,
                                 std::span<const FailedRequest> failures) const {
    const auto state = !failures.empty()             ? reason_text(texts_, failures.front().error)
                       : statistics.time.count() > 0 ? texts_("app.state.answering")
                                                     : texts_("app.state.unknown");
    return target_.empty() ? state : target_ + ": " + state;
}

std::string WatchReport::statistics_text(const WatchStatistics& statistics) const {
    const auto& time = statistics.time;
    return texts_("app.watch.statistics", {{"samples", std::to_string(statistics.samples)},
                                           {"answers", std::to_string(time.count())},
                                           {"errors", std::to_string(statistics.errors)},
                                           {"min", measured_time_text(texts_, time, time.min())},
                                           {"mean", measured_time_text(texts_, time, time.mean())},
                                           {"max", measured_time_text(texts_, time, time.max())}});
}

std::string reason_text(const Texts& texts, const Error& error) {
    switch (error.code) {
        case Code::timed_out: return texts("app.reason.timeout");
        case Code::modbus_exception:
            return texts("app.reason.exception", {{"code", std::to_string(error.numbers[0])}});
        case Code::bad_checksum: return texts("app.reason.bad_checksum");
        case Code::connection_lost: return texts("app.reason.link_lost");
        case Code::closed_by_peer: return texts("app.reason.closed");
        case Code::cannot_open: return texts("app.state.link_down");
        case Code::too_short:
        case Code::too_long:
        case Code::malformed:
        case Code::not_modbus:
        case Code::unexpected_reply:
        case Code::misdirected: return texts("app.reason.unexpected_reply");
        default: return without_stop(texts.describe(error));
    }
}

file::Json watch_error_json(const Texts& texts, const Error& error) {
    auto object = error_json(texts, error);
    object.set("event", "error");
    return object;
}

file::Json watch_summary_json(const WatchStatistics& statistics) {
    const auto& time = statistics.time;
    auto object = file::Json::object();
    object.set("event", "summary");
    object.set("samples", statistics.samples);
    object.set("answers", time.count());
    object.set("errors", statistics.errors);
    object.set("min_ms", milliseconds_json(time, time.min()));
    object.set("mean_ms", milliseconds_json(time, time.mean()));
    object.set("max_ms", milliseconds_json(time, time.max()));
    return object;
}

}  // namespace takt::report
