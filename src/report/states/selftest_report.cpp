#include "takt/report/states/selftest_report.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <vector>

#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/text_table.hpp"

namespace takt::report {
namespace {

using client::Subject;

/// Counts in rows that end at 1, 2, 5, 10 µs and so on.
struct HistogramRow {
    Duration upper{};
    std::uint64_t count = 0;
};

Duration next_end(Duration end) {
    return std::to_string(end.count()).front() == '2' ? end * 5 / 2 : end * 2;
}

std::vector<HistogramRow> histogram_rows(const LatencyStatistics& statistics) {
    std::vector<HistogramRow> rows{{std::chrono::microseconds(1), 0}};
    const auto& histogram = statistics.histogram();
    for (std::size_t i = 0; i < Histogram::kBuckets; ++i) {
        const auto bucket = histogram.bucket(i);
        if (bucket.count == 0) continue;
        while (bucket.lower >= rows.back().upper) rows.push_back({next_end(rows.back().upper), 0});
        rows.back().count += bucket.count;
    }
    const auto first = std::ranges::find_if(rows, [](const HistogramRow& row) { return row.count > 0; });
    rows.erase(rows.begin(), first);
    return rows;
}

/// A bar that grows with the logarithm of the count, so that one sample is seen beside thousands.
std::string bar_of(std::uint64_t count) {
    constexpr double kCharactersPerDecade = 8;
    if (count == 0) return {};
    const auto length =
        static_cast<std::size_t>(std::lround(std::log10(static_cast<double>(count)) * kCharactersPerDecade)) +
        1;
    return std::string(length, '#');
}

std::string histogram_text(const Texts& texts, const LatencyStatistics& statistics) {
    using enum TextTable::Align;
    TextTable table({right, right, left});
    for (const auto& row : histogram_rows(statistics))
        table.add({"< " + texts.duration(row.upper), std::to_string(row.count), bar_of(row.count)});
    return table.render("  ");
}

void add_rows(TextTable& table, const Texts& texts, const SelftestRun& run) {
    for (const auto subject : client::kSubjects) {
        const auto& measured = run[static_cast<std::size_t>(subject)];
        if (!measured) continue;
        const bool any = measured->count() > 0;
        const auto text = [&](Duration time) { return any ? texts.duration(time) : std::string("–"); };
        table.add({"  " + texts("selftest." + std::string(name(subject))), std::to_string(measured->count()),
                   text(measured->min()), text(measured->percentile(50)), text(measured->percentile(99)),
                   text(measured->percentile(99.9)), text(measured->max())});
    }
}

bool is_whole(const SelftestRun& run) {
    return std::ranges::all_of(run, [](const auto& measured) { return measured && measured->count() > 0; });
}

client::HostBudget budget_of(const SelftestRun& run) {
    return client::budget_of(*run[0], *run[1], *run[2]);
}

std::string project_time(Duration time) {
    return std::to_string(std::chrono::duration_cast<std::chrono::microseconds>(time).count()) + "us";
}

std::string host_line(const client::HostBudget& budget) {
    return "host: {jitter: " + project_time(budget.jitter) + ", overhead: " + project_time(budget.overhead) +
           "}";
}

file::Json statistics_json(const LatencyStatistics& statistics) {
    auto object = file::Json::object();
    object.set("samples", statistics.count());
    object.set("min_us", microseconds(statistics.min()));
    object.set("mean_us", microseconds(statistics.mean()));
    object.set("p50_us", microseconds(statistics.percentile(50)));
    object.set("p99_us", microseconds(statistics.percentile(99)));
    object.set("p999_us", microseconds(statistics.percentile(99.9)));
    object.set("max_us", microseconds(statistics.max()));
    auto histogram = file::Json::array();
    for (const auto& row : histogram_rows(statistics)) {
        auto pair = file::Json::array();
        pair.push_back(microseconds(row.upper));
        pair.push_back(row.count);
        histogram.push_back(std::move(pair));
    }
    object.set("histogram", std::move(histogram));
    return object;
}

file::Json run_json(const SelftestRun& run) {
    auto object = file::Json::object();
    for (const auto subject : client::kSubjects) {
        const auto& measured = run[static_cast<std::size_t>(subject)];
        object.set(name(subject), measured ? statistics_json(*measured) : file::Json());
    }
    if (!is_whole(run)) return object;
    const auto budget = budget_of(run);
    auto host = file::Json::object();
    host.set("jitter", project_time(budget.jitter));
    host.set("overhead", project_time(budget.overhead));
    object.set("host", std::move(host));
    return object;
}

}  // namespace

std::string_view name(Subject subject) {
    switch (subject) {
        case Subject::wake_up: return "wake_up";
        case Subject::loopback: return "loopback";
        case Subject::pty: return "pty";
    }
    return "wake_up";
}

std::string selftest_text(const Texts& texts, const SelftestReport& report) {
    using enum TextTable::Align;
    TextTable table({whole, right, right, right, right, right, right});
    table.add({texts("selftest.idle"), texts("selftest.samples"), texts("selftest.least"),
               texts("selftest.median"), "p99", "p99.9", texts("selftest.longest")});
    add_rows(table, texts, report.idle);
    table.add({texts("selftest.loaded", {{"count", std::to_string(report.load_threads)}})});
    add_rows(table, texts, report.loaded);
    std::string text = table.render();
    for (const auto subject : client::kSubjects) {
        const auto& measured = report.loaded[static_cast<std::size_t>(subject)];
        if (!measured || measured->count() == 0) continue;
        text += '\n' +
                texts("selftest.histogram", {{"subject", texts("selftest." + std::string(name(subject)))}}) +
                '\n' + histogram_text(texts, *measured);
    }
    if (!is_whole(report.idle) || !is_whole(report.loaded))
        return text + '\n' + texts("selftest.no_host") + '\n';
    text += '\n' + texts("selftest.host") + '\n';
    TextTable lines({whole, left});
    lines.add({"  " + host_line(budget_of(report.loaded)), "# " + texts("selftest.host.loaded")});
    lines.add({"  " + host_line(budget_of(report.idle)), "# " + texts("selftest.host.idle")});
    return text + lines.render();
}

file::Json selftest_json(const SelftestReport& report) {
    auto object = file::Json::object();
    object.set("load_threads", report.load_threads);
    object.set("idle", run_json(report.idle));
    object.set("loaded", run_json(report.loaded));
    return object;
}

}  // namespace takt::report
