#include "commands.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>

#include "output.hpp"
#include "takt/file/write.hpp"
#include "takt/model/nearest.hpp"
#include "takt/publish/project_outputs.hpp"
#include "takt/report/times/history_report.hpp"
#include "takt/report/times/history_svg.hpp"
#include "takt/report/times/history_time.hpp"
#include "texts.hpp"

namespace takt::app {
namespace {

using store::HistoryReader;
using store::HistorySeriesInfo;

std::optional<store::HistoryRange> range_of(const Texts& texts, const HistoryOptions& options) {
    const auto now = std::chrono::duration_cast<std::chrono::nanoseconds>(
        std::chrono::system_clock::now().time_since_epoch());
    const auto time_of = [&](const std::string& text) {
        const auto time = report::parse_history_time(text, now.count());
        if (!time) print_error(texts("app.history.no_time", {{"value", text}}));
        return time;
    };
    const auto from = time_of(options.from);
    const auto to = time_of(options.to);
    if (!from || !to) return std::nullopt;
    if (*from >= *to) {
        print_error(texts("app.history.no_range", {{"from", options.from}, {"to", options.to}}));
        return std::nullopt;
    }
    return store::HistoryRange{*from, *to};
}

/// Reports each name that is unknown, with the nearest known one. Variables with a damaged row are left out.
std::optional<std::vector<HistorySeriesInfo>> find_series(const Texts& texts, const HistoryOptions& options,
                                                          HistoryReader& reader,
                                                          const std::vector<HistorySeriesInfo>& all) {
    std::vector<HistorySeriesInfo> found;
    std::vector<std::string_view> names;
    for (const auto& info : all) names.emplace_back(info.series.name);
    bool complete = true;
    for (const auto& wanted : options.variables) {
        const auto known = std::ranges::find(all, wanted, [](const auto& info) { return info.series.name; });
        if (known != all.end()) {
            found.push_back(*known);
            continue;
        }
        if (reader.is_lost(wanted)) continue;
        complete = false;
        const auto nearest = model::nearest(wanted, names);
        print_error(nearest.empty() ? texts("app.history.unknown", {{"name", wanted}})
                                    : texts("app.history.unknown_nearest",
                                            {{"name", wanted}, {"nearest", std::string(nearest)}}));
    }
    if (!complete) return std::nullopt;
    return found;
}

/// `code`, or `partly` if samples may be missing.
ExitCode with_damage(ExitCode code, const HistoryReader& reader) {
    return reader.damage().empty() ? code : ExitCode::partly;
}

/// For what has no text of its own on standard output.
void print_damage(const Texts& texts, const HistoryReader& reader) {
    auto text = report::history_damage_text(texts, reader.damage());
    if (text.empty()) return;
    text.pop_back();  // the line end
    print_error(text);
}

ExitCode list_variables(const Texts& texts, const HistoryOptions& options, HistoryReader& reader,
                        const std::vector<HistorySeriesInfo>& all) {
    std::vector<report::HistoryListEntry> entries;
    for (const auto& info : all) {
        const auto extent = reader.extent(info.id);
        if (!extent) return ended_by(texts, extent.error());
        entries.push_back({info.series, *extent});
    }
    if (options.json) {
        print(report::history_list_json(entries, reader.damage()).dump() + '\n');
        print_damage(texts, reader);
    } else {
        print(report::history_list_text(texts, entries, columns_of(STDOUT_FILENO)) +
              report::history_damage_text(texts, reader.damage()));
    }
    return with_damage(ExitCode::ok, reader);
}

ExitCode print_csv(const Texts& texts, HistoryReader& reader, const std::vector<HistorySeriesInfo>& wanted,
                   const store::HistoryRange& range) {
    constexpr std::size_t kBlock = 64 << 10;
    std::string rows = report::history_csv_heading();
    for (const auto& info : wanted) {
        const auto read = reader.read(info.id, range, [&](const store::HistorySample& sample) {
            rows += report::history_csv_row(info.series, sample);
            if (rows.size() > kBlock) print(std::exchange(rows, {}));
            return stdout_error() == 0;
        });
        if (!read) return ended_by(texts, read.error());
    }
    for (const auto& damage : reader.damage()) rows += report::history_csv_row(damage);
    print(rows);
    print_damage(texts, reader);
    return with_damage(ExitCode::ok, reader);
}

ExitCode print_views(const Texts& texts, const HistoryOptions& options, HistoryReader& reader,
                     const std::vector<HistorySeriesInfo>& wanted, const store::HistoryRange& range) {
    std::vector<report::HistoryView> views;
    for (const auto& info : wanted) {
        const std::size_t pixels = options.svg.empty() ? options.points : report::kHistorySvgPixels;
        auto picture = reader.picture(info.id, range, pixels);
        if (!picture) return ended_by(texts, picture.error());
        auto last = reader.before(info.id, range.to_ns);
        if (!last) return ended_by(texts, last.error());
        views.push_back({info.series, std::move(*picture), std::move(*last)});
    }
    if (options.json) print(report::history_json(views, range, reader.damage()).dump() + '\n');
    if (!options.svg.empty()) {
        const auto picture = report::history_svg(
            texts,
            texts("app.history.title", {{"file", std::filesystem::path(options.file).filename().string()}}),
            views);
        if (options.svg == "-") {
            print_raw(picture);
        } else if (const auto written = file::write_file(options.svg, picture, true); !written) {
            return ended_by(texts, written.error());
        }
    }
    if (!options.json && options.svg != "-")
        print(report::history_text(texts, views, columns_of(STDOUT_FILENO)) +
              report::history_damage_text(texts, reader.damage()));
    else
        print_damage(texts, reader);
    const bool nothing = std::ranges::all_of(views, [](const auto& view) { return !view.last; });
    return with_damage(nothing ? ExitCode::no : ExitCode::ok, reader);
}

}  // namespace

ExitCode history(const CommonOptions& common, const HistoryOptions& options) {
    const Texts texts(common.language);
    const std::string path =
        options.database.empty() ? publish::history_database(options.file) : options.database;
    const auto range = range_of(texts, options);
    if (!range) return ExitCode::usage;
    auto reader = HistoryReader::open(path);
    if (!reader) return ended_by(texts, reader.error());
    const auto all = reader->series();
    if (!all) return ended_by(texts, all.error());
    if (options.variables.empty()) return list_variables(texts, options, *reader, *all);
    const auto wanted = find_series(texts, options, *reader, *all);
    if (!wanted) return ExitCode::usage;
    if (options.csv) return print_csv(texts, *reader, *wanted, *range);
    return print_views(texts, options, *reader, *wanted, *range);
}

}  // namespace takt::app
