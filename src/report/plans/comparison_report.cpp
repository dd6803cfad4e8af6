#include "takt/report/plans/comparison_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/text_table.hpp"

namespace takt::report {
namespace {

using Align = TextTable::Align;

constexpr std::size_t kCostBarWidth = 24;  // characters

/// A column of the table: its heading, its text for a cost, and the saving below it.
struct CostFigure {
    const char* heading;
    std::string (*cost)(const Texts&, const plan::Cost&);
    double plan::Saving::* saved;
};

const CostFigure kRequestsFigure{
    "app.requests", [](const Texts&, const plan::Cost& cost) { return std::to_string(cost.requests); },
    &plan::Saving::requests};
const CostFigure kRequestRateFigure{
    "app.requests_per_second",
    [](const Texts&, const plan::Cost& cost) { return per_second_text(cost.requests_per_second); },
    &plan::Saving::requests_per_second};
const CostFigure kBytesFigure{"app.bytes",
                              [](const Texts&, const plan::Cost& cost) { return std::to_string(cost.bytes); },
                              &plan::Saving::bytes};
const CostFigure kByteRateFigure{
    "app.bytes_per_second",
    [](const Texts&, const plan::Cost& cost) { return per_second_text(cost.bytes_per_second); },
    &plan::Saving::bytes_per_second};
const CostFigure kBusTimeFigure{
    "app.bus_time", [](const Texts& texts, const plan::Cost& cost) { return texts.duration(cost.bus_time); },
    &plan::Saving::bus_time};
const CostFigure kCycleFigure{
    "app.cycle", [](const Texts& texts, const plan::Cost& cost) { return texts.duration(cost.cycle); },
    &plan::Saving::cycle};
const CostFigure kBusyFigure{
    "app.line_busy",
    [](const Texts&, const plan::Cost& cost) { return fmt::format("{:.1f} %", cost.utilization * 100); },
    &plan::Saving::utilization};

std::vector<CostFigure> cost_figures(const plan::Comparison& comparison) {
    if (comparison.takes_turns()) return {kRequestRateFigure, kByteRateFigure, kBusyFigure};
    return {kRequestsFigure, kRequestRateFigure, kBytesFigure, kBusTimeFigure, kCycleFigure, kBusyFigure};
}

/// A bar in eighths of a character, as long as `share` of the widest, which has `width` characters.
std::string eighths_bar(double share, std::size_t width) {
    static constexpr const char* kEighths[] = {"", "▏", "▎", "▍", "▌", "▋", "▊", "▉"};
    const auto eighths =
        static_cast<std::size_t>(std::lround(std::clamp(share, 0.0, 1.0) * static_cast<double>(width) * 8));
    std::string text;
    for (std::size_t i = 0; i < eighths / 8; ++i) text += "█";
    return text + kEighths[eighths % 8];
}

/// The value that the bars show: the load, or the bus time where nothing has a period or the line is never
/// idle.
double bar_value(const plan::Comparison& comparison, const plan::Cost& cost) {
    const bool by_load = comparison.single.utilization > 0 && !comparison.single.saturated;
    return by_load ? cost.utilization : static_cast<double>(cost.bus_time.count());
}

/// @param bar_width  characters of the longest bar; 0: no bars
TextTable comparison_table(const Texts& texts, const std::string& line, const plan::Comparison& comparison,
                           std::size_t bar_width) {
    const auto shown = cost_figures(comparison);
    std::vector<Align> columns(shown.size() + 2, Align::right);
    columns.front() = columns.back() = Align::left;
    TextTable table(columns);
    std::vector<std::string> cells{line};
    for (const auto& figure : shown) cells.push_back(texts(figure.heading));
    table.add(cells);
    const auto rows = compared_rows(texts, comparison);
    double widest = 0;
    for (const auto& row : rows) widest = std::max(widest, bar_value(comparison, *row.cost));
    for (const auto& row : rows) {
        cells = {row.name};
        for (const auto& figure : shown) cells.push_back(figure.cost(texts, *row.cost));
        cells.push_back(widest > 0 ? eighths_bar(bar_value(comparison, *row.cost) / widest, bar_width)
                                   : std::string());
        table.add(cells);
        if (!row.saved && !row.configured) continue;
        cells = {row.configured ? "  " + texts("app.as_configured") : std::string()};
        for (const auto& figure : shown)
            if (row.saved) cells.push_back(saving_text(row.saved->*figure.saved));
        table.add(cells);
    }
    return table;
}

/// The table with bars as wide as the terminal allows.
std::string fitting_table(const Texts& texts, const std::string& line, const plan::Comparison& comparison,
                          std::size_t columns) {
    std::size_t widest = 0;
    const auto table = comparison_table(texts, line, comparison, kCostBarWidth);
    for (const auto& row : table.lines()) widest = std::max(widest, display_width(row));
    if (widest <= columns) return table.render();
    const auto left = kCostBarWidth - std::min(kCostBarWidth, widest - columns);
    return comparison_table(texts, line, comparison, left).render();
}

file::Json saving_json(const plan::Saving& saved) {
    auto object = file::Json::object();
    object.set("requests", saved.requests);
    object.set("bytes", saved.bytes);
    object.set("bus_time", saved.bus_time);
    object.set("cycle", saved.cycle);
    object.set("utilization", saved.utilization);
    object.set("requests_per_second", saved.requests_per_second);
    object.set("bytes_per_second", saved.bytes_per_second);
    return object;
}

file::Json cost_json(const plan::Cost& cost) {
    auto object = file::Json::object();
    object.set("requests", static_cast<std::uint64_t>(cost.requests));
    object.set("bytes", cost.bytes);
    object.set("bus_time_us", whole_microseconds(cost.bus_time));
    object.set("cycle_us", whole_microseconds(cost.cycle));
    object.set("utilization", cost.utilization);
    object.set("requests_per_second", cost.requests_per_second);
    object.set("bytes_per_second", cost.bytes_per_second);
    return object;
}

}  // namespace

std::string per_second_text(double rate) {
    return fmt::format("{:.{}f}", rate, rate < 100 ? 1 : 0);
}

std::string saving_text(double percent) {
    return std::abs(percent) < 0.5 ? "0 %" : fmt::format("{:+.0f} %", -percent);
}

std::vector<ComparedRow> compared_rows(const Texts& texts, const plan::Comparison& comparison) {
    std::vector<ComparedRow> rows;
    for (const auto& each : comparison.strategies) {
        const bool single = each.strategy == model::Strategy::single;
        rows.push_back({std::string(model::name(each.strategy)), model::name(each.strategy), &each.cost,
                        single ? nullptr : &each.saved, each.strategy == comparison.configured});
    }
    if (!comparison.configured)
        rows.push_back({texts("app.mixed"), "mixed", &comparison.grouped, &comparison.saved, true});
    return rows;
}

std::string comparison_text(const Texts& texts, const model::Project& project, const plan::Plan& plan,
                            std::size_t columns) {
    std::string text;
    for (const auto& comparison : plan::compare(project, plan))
        text += fitting_table(texts, project.lines[comparison.line].name, comparison, columns);
    return text;
}

file::Json comparison_json(const plan::Comparison& comparison) {
    auto strategies = file::Json::object();
    for (const auto& each : comparison.strategies) {
        auto strategy = cost_json(each.cost);
        strategy.set("saved_percent", saving_json(each.saved));
        strategies.set(model::name(each.strategy), std::move(strategy));
    }
    auto object = file::Json::object();
    object.set("grouped", cost_json(comparison.grouped));
    object.set("ungrouped", cost_json(comparison.single));
    object.set("saved_percent", saving_json(comparison.saved));
    object.set("strategies", std::move(strategies));
    return object;
}

}  // namespace takt::report
