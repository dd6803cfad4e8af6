#include "takt/report/times/history_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/text_table.hpp"
#include "takt/report/drawing/value_json.hpp"
#include "takt/report/times/history_time.hpp"
#include "takt/value/text.hpp"

namespace takt::report {
namespace {

constexpr std::size_t kMostListedSpans = 20;  // of gaps, and of bad times
constexpr std::array<std::string_view, 8> kSparkBlocks{"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};

std::string number_text(const store::HistorySeries& series, double value) {
    return value::format(
        series.type == DataType::float32 && !series.scaled ? DataType::float32 : DataType::float64, false,
        value);
}

std::string optional_number(const store::HistorySeries& series, std::optional<double> value) {
    return value ? number_text(series, *value) : "–";
}

/// A mean has no more digits than it deserves.
std::string mean_text(std::optional<double> mean) {
    return mean ? fmt::format("{:.6g}", *mean) : "–";
}

/// One character a column: the greatest value in it, between the least and the greatest of all. A blank where
/// there is no value.
std::string small_picture(const store::HistoryPicture& picture, std::size_t width) {
    const double least = picture.min.value_or(0);
    const double span = picture.max.value_or(0) - least;
    const auto bar = [&](double value) {
        const double share = span > 0 ? (value - least) / span : 0.5;
        const auto level = static_cast<std::size_t>(std::clamp(share, 0.0, 1.0) * 7.99);
        return kSparkBlocks[level];
    };
    const double column_ns =
        (static_cast<double>(picture.range.to_ns) - static_cast<double>(picture.range.from_ns)) /
        static_cast<double>(width);
    const auto is_lost = [&picture](std::int64_t time) {
        const auto covers = [time](std::int64_t from, std::int64_t to) { return time >= from && time < to; };
        return time >= picture.known_until_ns ||
               std::ranges::any_of(picture.gaps,
                                   [&](const auto& gap) { return covers(gap.first_ns, gap.last_ns); }) ||
               std::ranges::any_of(picture.bad, [&](const auto& span_of_bad) {
                   return span_of_bad.quality != value::Quality::uncertain &&
                          covers(span_of_bad.range.from_ns, span_of_bad.range.to_ns);
               });
    };
    std::string text;
    std::optional<double> held;
    if (picture.held) held = picture.held->value;
    auto pixel = picture.pixels.begin();
    for (std::size_t i = 0; i < width; ++i) {
        const auto end =
            picture.range.from_ns + static_cast<std::int64_t>(static_cast<double>(i + 1) * column_ns);
        std::optional<double> greatest;
        for (; pixel != picture.pixels.end() && pixel->range.from_ns < end; ++pixel) {
            if (!pixel->has_value) continue;
            greatest = std::max(greatest.value_or(pixel->max.value), pixel->max.value);
            held = pixel->last.value;
        }
        if (!greatest && !is_lost(end - static_cast<std::int64_t>(column_ns / 2))) greatest = held;
        text += greatest ? bar(*greatest) : " ";
    }
    return text;
}

std::string range_of_times(const store::HistoryRange& range) {
    return short_time_text(range.from_ns, INT64_MIN) + " – " + short_time_text(range.to_ns, range.from_ns);
}

void add_row(TextTable& table, const Texts& texts, const HistoryView& view) {
    const auto& [series, picture, last] = view;
    const std::string newest = last ? value::format(series.type, series.scaled, last->value) : "–";
    table.add({series.name, last && value::is_empty(last->value) ? "–" : newest, series.unit,
               last ? texts.quality(last->quality, last->reason) : "–", optional_number(series, picture.min),
               mean_text(picture.mean), optional_number(series, picture.max),
               fmt::format("{:.2f} %", std::floor(picture.good_share * 10'000) / 100),
               std::to_string(picture.samples)});
}

std::string gaps_text(const Texts& texts, std::span<const store::HistoryGap> gaps) {
    if (gaps.empty()) return {};
    using enum TextTable::Align;
    TextTable table({left, left, right});
    for (const auto& gap : gaps.first(std::min(gaps.size(), kMostListedSpans)))
        table.add(
            {range_of_times({gap.first_ns, gap.last_ns}), gap_text(texts, gap.cause),
             gap.samples > 0 ? texts("app.history.lost", {{"count", std::to_string(gap.samples)}}) : ""});
    std::string text =
        texts("app.history.gaps", {{"count", std::to_string(gaps.size())}}) + '\n' + table.render("  ");
    if (gaps.size() > kMostListedSpans)
        text += "  " +
                texts("app.history.more", {{"count", std::to_string(gaps.size() - kMostListedSpans)}}) + '\n';
    return text;
}

std::string bad_text(const Texts& texts, const HistoryView& view) {
    const auto& bad = view.picture.bad;
    if (bad.empty()) return {};
    using enum TextTable::Align;
    TextTable table({left, left});
    for (const auto& span : std::span(bad).first(std::min(bad.size(), kMostListedSpans)))
        table.add({range_of_times(span.range), texts.quality(span.quality, span.reason)});
    std::string text =
        texts("app.history.bad", {{"name", view.series.name}, {"count", std::to_string(bad.size())}}) + '\n' +
        table.render("  ");
    if (bad.size() > kMostListedSpans)
        text += "  " + texts("app.history.more", {{"count", std::to_string(bad.size() - kMostListedSpans)}}) +
                '\n';
    return text;
}

file::Json optional_json(std::optional<double> value) {
    return value ? file::Json(*value) : file::Json();
}

void set_state(file::Json& object, value::Quality quality, value::Reason reason) {
    object.set("quality", value::name(quality));
    if (reason == value::Reason::ok) return;
    object.set("reason", value::name(reason));
    object.set("status", value::status_code(reason));
}

file::Json point_json(const store::HistoryPoint& point) {
    auto object = file::Json::object();
    object.set("time", utc_time_text(point.time_ns));
    object.set("value", point.value);
    if (point.previous_ns) object.set("previous_poll", utc_time_text(*point.previous_ns));
    return object;
}

file::Json view_json(const HistoryView& view) {
    const auto& [series, picture, last] = view;
    auto object = file::Json::object();
    object.set("name", series.name);
    object.set("device", series.device);
    object.set("type", name(series.type));
    object.set("unit", series.unit);
    if (last) {
        auto newest = file::Json::object();
        newest.set("time", utc_time_text(last->time_ns));
        newest.set("value", to_json(series.type, series.scaled, last->value));
        set_state(newest, last->quality, last->reason);
        object.set("last", std::move(newest));
    }
    object.set("samples", picture.samples);
    object.set("min", optional_json(picture.min));
    object.set("mean", optional_json(picture.mean));
    object.set("max", optional_json(picture.max));
    object.set("good_share", picture.good_share);
    object.set("known_until", utc_time_text(picture.known_until_ns));
    object.set("damaged_chunks", picture.damaged_chunks);
    object.set("held", picture.held ? point_json(*picture.held) : file::Json());
    file::Json::Array pixels;
    for (const auto& pixel : picture.pixels) {
        auto item = file::Json::object();
        item.set("index", pixel.index);
        item.set("samples", pixel.samples);
        if (pixel.has_value) {
            item.set("first", point_json(pixel.first));
            item.set("min", point_json(pixel.min));
            item.set("max", point_json(pixel.max));
            item.set("last", point_json(pixel.last));
        }
        pixels.push_back(std::move(item));
    }
    object.set("points", file::Json(std::move(pixels)));
    file::Json::Array bad;
    for (const auto& span : picture.bad) {
        auto item = file::Json::object();
        item.set("from", utc_time_text(span.range.from_ns));
        item.set("to", utc_time_text(span.range.to_ns));
        set_state(item, span.quality, span.reason);
        bad.push_back(std::move(item));
    }
    object.set("bad", file::Json(std::move(bad)));
    return object;
}

file::Json gaps_json(std::span<const store::HistoryGap> gaps) {
    file::Json::Array items;
    for (const auto& gap : gaps) {
        auto item = file::Json::object();
        item.set("from", utc_time_text(gap.first_ns));
        item.set("to", utc_time_text(gap.last_ns));
        item.set("cause", store::name(gap.cause));
        item.set("samples", gap.samples > 0 ? file::Json(gap.samples) : file::Json());
        items.push_back(std::move(item));
    }
    return file::Json(std::move(items));
}

file::Json damage_json(std::span<const store::HistoryDamage> damage) {
    const auto time = [](std::optional<std::int64_t> time_ns) {
        return time_ns ? file::Json(utc_time_text(*time_ns)) : file::Json();
    };
    file::Json::Array items;
    for (const auto& its : damage) {
        auto item = file::Json::object();
        item.set("part", store::name(its.part));
        item.set("row", its.row > 0 ? file::Json(its.row) : file::Json());
        item.set("variable", its.variable.empty() ? file::Json() : file::Json(its.variable));
        item.set("from", time(its.first_ns));
        item.set("to", time(its.last_ns));
        item.set("samples", its.samples > 0 ? file::Json(its.samples) : file::Json());
        items.push_back(std::move(item));
    }
    return file::Json(std::move(items));
}

}  // namespace

std::string gap_text(const Texts& texts, store::GapCause cause) {
    return texts("app.history.cause." + std::string(store::name(cause)));
}

std::string history_text(const Texts& texts, const std::vector<HistoryView>& views, std::size_t columns) {
    using enum TextTable::Align;
    TextTable table({left, right, left, left, right, right, right, right, right});
    table.add({texts("app.history.variable"), texts("app.history.last"), texts("app.history.unit"),
               texts("app.history.quality"), texts("app.history.min"), texts("app.history.mean"),
               texts("app.history.max"), texts("app.history.good"), texts("app.history.samples")});
    for (const auto& view : views) add_row(table, texts, view);
    std::string text;
    if (!views.empty()) text += range_of_times(views.front().picture.range) + '\n';
    text += table.render("", columns);
    if (columns != SIZE_MAX) {
        for (const auto& view : views) {
            if (view.picture.min)
                text += '\n' + view.series.name + '\n' +
                        small_picture(view.picture, std::clamp<std::size_t>(columns, 10, 200)) + '\n';
        }
    }
    if (!views.empty()) text += gaps_text(texts, views.front().picture.gaps);
    for (const auto& view : views) {
        text += bad_text(texts, view);
        if (view.picture.damaged_chunks > 0)
            text += texts("app.history.damaged", {{"name", view.series.name},
                                                  {"count", std::to_string(view.picture.damaged_chunks)}}) +
                    '\n';
    }
    return text;
}

file::Json history_json(const std::vector<HistoryView>& views, const store::HistoryRange& range,
                        std::span<const store::HistoryDamage> damage) {
    auto object = file::Json::object();
    object.set("from", utc_time_text(range.from_ns));
    object.set("to", utc_time_text(range.to_ns));
    file::Json::Array variables;
    for (const auto& view : views) variables.push_back(view_json(view));
    object.set("variables", file::Json(std::move(variables)));
    object.set("gaps", views.empty() ? file::Json::array() : gaps_json(views.front().picture.gaps));
    object.set("damage", damage_json(damage));
    return object;
}

std::string history_damage_text(const Texts& texts, std::span<const store::HistoryDamage> damage) {
    if (damage.empty()) return {};
    using enum TextTable::Align;
    TextTable table({left, left, left, right});
    for (const auto& its : damage)
        table.add(
            {its.variable.empty() ? "–" : its.variable,
             its.first_ns && its.last_ns ? range_of_times({*its.first_ns, *its.last_ns}) : "–",
             texts("app.history.part." + std::string(store::name(its.part))),
             its.samples > 0 ? texts("app.history.lost", {{"count", std::to_string(its.samples)}}) : ""});
    return texts("app.history.damage", {{"count", std::to_string(damage.size())}}) + '\n' +
           table.render("  ");
}

std::string history_list_text(const Texts& texts, const std::vector<HistoryListEntry>& entries,
                              std::size_t columns) {
    using enum TextTable::Align;
    TextTable table({left, left, left, left, left});
    table.add({texts("app.history.variable"), texts("app.history.device"), texts("app.history.unit"),
               texts("app.history.oldest"), texts("app.history.newest")});
    for (const auto& [series, extent] : entries)
        table.add({series.name, series.device, series.unit,
                   extent ? short_time_text(extent->from_ns, INT64_MIN) : "–",
                   extent ? short_time_text(extent->to_ns, INT64_MIN) : "–"});
    return table.render("", columns);
}

file::Json history_list_json(const std::vector<HistoryListEntry>& entries,
                             std::span<const store::HistoryDamage> damage) {
    file::Json::Array variables;
    for (const auto& [series, extent] : entries) {
        auto item = file::Json::object();
        item.set("name", series.name);
        item.set("device", series.device);
        item.set("type", name(series.type));
        item.set("unit", series.unit);
        item.set("oldest", extent ? file::Json(utc_time_text(extent->from_ns)) : file::Json());
        item.set("newest", extent ? file::Json(utc_time_text(extent->to_ns)) : file::Json());
        variables.push_back(std::move(item));
    }
    auto object = file::Json::object();
    object.set("variables", file::Json(std::move(variables)));
    object.set("damage", damage_json(damage));
    return object;
}

std::string history_csv_heading() {
    return "variable,time_utc,time_local,value,quality,reason,previous_poll_utc\n";
}

std::string history_csv_row(const store::HistorySeries& series, const store::HistorySample& sample) {
    const bool is_ok = sample.reason == value::Reason::ok;
    const std::string reason = is_ok ? ""
                               : value::is_exception(sample.reason)
                                   ? fmt::format("exception {}", value::status_code(sample.reason) % 256)
                                   : std::string(value::name(sample.reason));
    return fmt::format("{},{},{},{},{},{},{}\n", csv_cell(series.name, ','), utc_time_text(sample.time_ns),
                       local_time_text(sample.time_ns),
                       csv_cell(value::format(series.type, series.scaled, sample.value), ','),
                       value::name(sample.quality), reason,
                       sample.previous_ns ? utc_time_text(*sample.previous_ns) : "");
}

std::string history_csv_row(const store::HistoryDamage& damage) {
    std::string reason(store::name(damage.part));
    if (damage.last_ns) reason += " until " + utc_time_text(*damage.last_ns);
    return fmt::format("{},{},{},,damaged,{},\n", csv_cell(damage.variable, ','),
                       damage.first_ns ? utc_time_text(*damage.first_ns) : "",
                       damage.first_ns ? local_time_text(*damage.first_ns) : "", reason);
}

}  // namespace takt::report
