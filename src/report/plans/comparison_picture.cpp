#include <fmt/format.h>

#include <algorithm>

#include "drawing/picture.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/plans/comparison_report.hpp"

namespace takt::report::picture {
namespace {

constexpr double kComparedRowHeight = 22;
constexpr double kComparedColumns = 3;
constexpr double kColumnGap = 28;
constexpr double kNameWidth = 74;
constexpr double kValueWidth = 112;

struct ComparedColumn {
    const char* caption;
    double (*size)(const plan::Cost&);
    std::string (*value)(const Texts&, const plan::Cost&);
    double plan::Saving::* saved;
};

const ComparedColumn kRequestsColumn{
    "app.requests", [](const plan::Cost& cost) { return static_cast<double>(cost.requests); },
    [](const Texts&, const plan::Cost& cost) { return std::to_string(cost.requests); },
    &plan::Saving::requests};
const ComparedColumn kRequestRateColumn{
    "app.requests_per_second", [](const plan::Cost& cost) { return cost.requests_per_second; },
    [](const Texts&, const plan::Cost& cost) { return per_second_text(cost.requests_per_second); },
    &plan::Saving::requests_per_second};
const ComparedColumn kCycleColumn{
    "app.cycle", [](const plan::Cost& cost) { return static_cast<double>(cost.cycle.count()); },
    [](const Texts& texts, const plan::Cost& cost) { return texts.duration(cost.cycle); },
    &plan::Saving::cycle};
const ComparedColumn kByteRateColumn{
    "app.bytes_per_second", [](const plan::Cost& cost) { return cost.bytes_per_second; },
    [](const Texts&, const plan::Cost& cost) { return per_second_text(cost.bytes_per_second); },
    &plan::Saving::bytes_per_second};
const ComparedColumn kBusyColumn{
    "app.line_busy", [](const plan::Cost& cost) { return cost.utilization; },
    [](const Texts&, const plan::Cost& cost) { return fmt::format("{:.1f} %", cost.utilization * 100); },
    &plan::Saving::utilization};

void draw_column(Svg& svg, const Texts& texts, const std::vector<ComparedRow>& rows,
                 const ComparedColumn& column, double x, double y, double width) {
    double widest = 0;
    for (const auto& row : rows) widest = std::max(widest, column.size(*row.cost));
    const double most = width - kNameWidth - kValueWidth;
    for (const auto& row : rows) {
        const double length = widest > 0 ? std::max(column.size(*row.cost) / widest * most, 1.0) : 1.0;
        const std::string_view weight = row.configured ? "row strong" : "row";
        svg.text(x + kNameWidth - 8, y + 12, weight, text_within(row.name, 12, kNameWidth));
        svg.rect({x + kNameWidth, y + 1, length, kComparedRowHeight - 8}, row.style);
        std::string value = column.value(texts, *row.cost);
        if (row.saved) value += "  (" + saving_text(row.saved->*column.saved) + ")";
        svg.text(x + kNameWidth + length + 6, y + 12, row.configured ? "small strong" : "small", value);
        y += kComparedRowHeight;
    }
}

}  // namespace

double draw_comparison(Svg& svg, const Texts& texts, const plan::Comparison& comparison, double top) {
    const auto rows = compared_rows(texts, comparison);
    const double width = (kWidth - 2 * kMargin - (kComparedColumns - 1) * kColumnGap) / kComparedColumns;
    const double y = top + 26;
    double x = kMargin;
    for (const ComparedColumn* column :
         {comparison.takes_turns() ? &kRequestRateColumn : &kRequestsColumn,
          comparison.takes_turns() ? &kByteRateColumn : &kCycleColumn, &kBusyColumn}) {
        svg.text(x + kNameWidth, y, "caption", texts(column->caption));
        draw_column(svg, texts, rows, *column, x, y + 10, width);
        x += width + kColumnGap;
    }
    const double end = y + 10 + kComparedRowHeight * static_cast<double>(rows.size());
    svg.text(kMargin + kNameWidth, end + 12, "small caption", texts("app.svg.bold"));
    return end + 14;
}

}  // namespace takt::report::picture
