#include "takt/web/history_api.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <expected>
#include <filesystem>
#include <iterator>
#include <optional>
#include <utility>

#include "takt/publish/project_outputs.hpp"
#include "takt/report/times/history_report.hpp"
#include "takt/report/times/history_time.hpp"
#include "takt/store/history_reader.hpp"

namespace takt::web {
namespace {

using store::HistoryReader;
using store::HistorySeriesInfo;

ApiResponse history_refusal(const ApiRequest& request, int status, std::string_view code,
                            const report::Texts::Arguments& arguments = {}) {
    return ApiResponse::error(status, code, request.texts("web.history." + std::string(code), arguments));
}

ApiResponse history_failure(const ApiRequest& request, const Error& error) {
    return ApiResponse::error(error.code == Code::not_found ? 404 : 500, "history",
                              request.texts.describe(error));
}

template <class Number>
std::optional<Number> parsed_number(std::string_view text) {
    Number number{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return number;
}

/// A history that is open for one request.
struct OpenedHistory {
    HistoryReader reader;
    std::vector<HistorySeriesInfo> series;
};

/// The variables and the range of a query.
struct HistoryQuery {
    std::vector<HistorySeriesInfo> wanted;
    store::HistoryRange range;
};

std::expected<OpenedHistory, ApiResponse> open_history(const HistoryApiOptions& options,
                                                       const ApiRequest& request) {
    const auto configuration = options.configuration();
    if (configuration == nullptr || !has_history(configuration->project()))
        return std::unexpected(history_refusal(request, 404, "none"));
    auto reader = HistoryReader::open(publish::history_database(options.project_file));
    if (!reader) return std::unexpected(history_failure(request, reader.error()));
    auto series = reader->series();
    if (!series) return std::unexpected(history_failure(request, series.error()));
    return OpenedHistory{*std::move(reader), *std::move(series)};
}

std::optional<std::int64_t> history_time_in(std::string_view text, std::string_view missing) {
    constexpr std::int64_t kNsPerMs = 1'000'000;
    constexpr std::int64_t kMost = 4'000'000'000'000;  // the year 2096
    if (text.empty()) text = missing;
    if (const auto ms = parsed_number<std::int64_t>(text); ms && *ms >= 0 && *ms <= kMost)
        return *ms * kNsPerMs;
    const auto now = std::chrono::duration_cast<std::chrono::nanoseconds>(
        std::chrono::system_clock::now().time_since_epoch());
    return report::parse_history_time(text, now.count());
}

std::expected<HistoryQuery, ApiResponse> query_of(const ApiRequest& request, OpenedHistory& history) {
    HistoryQuery query;
    const auto [begin, end] = request.query.equal_range("variable");
    for (auto it = begin; it != end; ++it) {
        const auto known =
            std::ranges::find(history.series, it->second, [](const auto& info) { return info.series.name; });
        if (known != history.series.end())
            query.wanted.push_back(*known);
        else if (!history.reader.is_lost(it->second))  // else the answer has its damage
            return std::unexpected(history_refusal(request, 404, "unknown", {{"name", it->second}}));
    }
    if (begin == end || std::cmp_greater(std::distance(begin, end), kMostHistoryVariables))
        return std::unexpected(
            history_refusal(request, 400, "variables", {{"allowed", std::to_string(kMostHistoryVariables)}}));
    const auto from = history_time_in(request.parameter("from"), "-1h");
    const auto to = history_time_in(request.parameter("to"), "now");
    if (!from || !to || *from >= *to) return std::unexpected(history_refusal(request, 400, "range"));
    query.range = {*from, *to};
    return query;
}

ApiResponse series(const HistoryApiOptions& options, const ApiRequest& request) {
    auto history = open_history(options, request);
    if (!history) return std::move(history.error());
    std::vector<report::HistoryListEntry> entries;
    for (const auto& info : history->series) {
        const auto extent = history->reader.extent(info.id);
        if (!extent) return history_failure(request, extent.error());
        entries.push_back({info.series, *extent});
    }
    return ApiResponse::json(report::history_list_json(entries, history->reader.damage()));
}

ApiResponse picture(const HistoryApiOptions& options, const ApiRequest& request) {
    auto history = open_history(options, request);
    if (!history) return std::move(history.error());
    const auto query = query_of(request, *history);
    if (!query) return query.error();
    const auto given = request.parameter("pixels");
    const auto pixels = given.empty() ? std::optional<std::size_t>(800) : parsed_number<std::size_t>(given);
    if (!pixels || *pixels < 1 || *pixels > kMostHistoryPixels)
        return history_refusal(request, 400, "pixels", {{"allowed", std::to_string(kMostHistoryPixels)}});
    std::vector<report::HistoryView> views;
    for (const auto& info : query->wanted) {
        auto drawn = history->reader.picture(info.id, query->range, *pixels);
        if (!drawn) return history_failure(request, drawn.error());
        auto last = history->reader.before(info.id, query->range.to_ns);
        if (!last) return history_failure(request, last.error());
        views.push_back({info.series, *std::move(drawn), *std::move(last)});
    }
    return ApiResponse::json(report::history_json(views, query->range, history->reader.damage()));
}

ApiResponse table(const HistoryApiOptions& options, const ApiRequest& request) {
    auto history = open_history(options, request);
    if (!history) return std::move(history.error());
    const auto query = query_of(request, *history);
    if (!query) return query.error();
    ApiResponse response{.content_type = "text/csv; charset=utf-8",
                         .body = report::history_csv_heading(),
                         .file_name = "history.csv"};
    std::size_t rows = 0;
    bool fits = true;
    for (const auto& info : query->wanted) {
        const auto read =
            history->reader.read(info.id, query->range, [&](const store::HistorySample& sample) {
                response.body += report::history_csv_row(info.series, sample);
                return fits = ++rows <= kMostHistoryRows && response.body.size() <= kMostHistoryBytes;
            });
        if (!read) return history_failure(request, read.error());
        if (!fits)
            return history_refusal(request, 422, "rows", {{"allowed", std::to_string(kMostHistoryRows)}});
    }
    for (const auto& damage : history->reader.damage()) response.body += report::history_csv_row(damage);
    return response;
}

}  // namespace

bool has_history(const model::Project& project) {
    return std::ranges::any_of(project.outputs, [](const model::Output& output) {
        return output.transport == model::OutputTransport::history;
    });
}

std::string marks_file(const std::string& project_file) {
    const std::filesystem::path database = publish::history_database(project_file);  // plant.history.db
    return (database.parent_path() / database.stem()).replace_extension(".marks.jsonl").string();
}

std::vector<ApiRoute> history_routes(const HistoryApiOptions& options) {
    const auto with_options = [&](auto handler) {
        return [options, handler](const ApiRequest& request) { return handler(options, request); };
    };
    return {{.method = Method::get, .path = "/history/series", .handler = with_options(series)},
            {.method = Method::get, .path = "/history", .handler = with_options(picture)},
            {.method = Method::get, .path = "/history.csv", .handler = with_options(table)}};
}

}  // namespace takt::web
