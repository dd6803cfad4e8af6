#include "takt/report/plans/plan_svg.hpp"

#include <algorithm>

#include "drawing/picture.hpp"
#include "takt/report/plans/plan_report.hpp"

namespace takt::report {
namespace {

constexpr std::size_t kMostDrawnLines = 40;
constexpr std::size_t kMostBarsOfPage = 6000;  // of the page
constexpr std::size_t kMostBarsOfLine = 2000;
constexpr double kLegendHeight = 34;

// Hues that stay apart for every kind of colour vision (Okabe and Ito), dark text on white.
constexpr std::string_view kPlanStyleSheet = R"(.page{fill:#fff}
text{font-family:system-ui,"DejaVu Sans","Noto Sans",Arial,sans-serif;font-size:13px;fill:#1c2733}
.heading{font-size:19px;font-weight:600}
.line{font-size:15px;font-weight:600}
.caption{fill:#44515e}
.small{font-size:11px}
.tick{font-size:11px;fill:#44515e;text-anchor:middle}
.row{font-size:12px;text-anchor:end}
.strong{font-weight:700}
.end{text-anchor:end}
.stripe{fill:#f5f7f9}
.grid{stroke:#dde3e9;stroke-width:1}
.axis{stroke:#7b8794;stroke-width:1}
.edge{stroke:#fff;stroke-width:1}
.rule{stroke:#c3ccd5;stroke-width:1}
.zoom{fill:#0072b2;fill-opacity:.08;stroke:#0072b2;stroke-opacity:.45;stroke-width:1}
.silence{fill:#a9b4c0}
.request{fill:#0072b2}
.turnaround{fill:#f2dd7e}
.response{fill:#d55e00}
.pause{fill:#fff;stroke:#a9b4c0;stroke-width:1}
.whole{fill:#4a5866}
.background{opacity:.4}
.late{fill:#b0004e}
.single{fill:#8a949f}
.classic{fill:#56b4e9}
.optimal{fill:#009e73}
.mixed{fill:#cc79a7}
)";

void draw_plan_legend(Svg& svg, const Texts& texts, const picture::Legend& legend, double y) {
    double x = picture::kMargin;
    const auto entry = [&](const char* style, const std::string& text = {}) {
        const std::string name = text.empty() ? texts(std::string("app.svg.") + style) : text;
        svg.rect({x, y - 11, 22, 13}, style);
        svg.text(x + 29, y, "", name);
        x += 29 + text_width(name, picture::kBody) + 16;
    };
    for (const char* style : {"silence", "request", "turnaround", "response"}) entry(style);
    if (legend.pause) entry("pause");
    if (legend.whole) entry("whole");
    if (legend.late) entry("late");
    if (legend.background) entry("whole background", texts("app.when.always"));
}

}  // namespace

std::string plan_svg(const Texts& texts, const std::string& name, const model::Project& project,
                     const plan::Plan& plan) {
    Svg svg;
    picture::Legend legend;
    const auto comparisons = plan::compare(project, plan);
    const std::size_t drawn = std::min(plan.lines.size(), kMostDrawnLines);
    const std::size_t most_bars =
        std::min(kMostBarsOfLine, kMostBarsOfPage / std::max<std::size_t>(drawn, 1));
    double y = 38;
    const std::string title = texts("app.svg.title", {{"file", name}});
    svg.text(picture::kMargin, y, "heading", text_within(title, 19, picture::kWidth - 2 * picture::kMargin));
    y += kLegendHeight;
    const double legend_y = y - 2;
    for (std::size_t i = 0; i < drawn; ++i) {
        y += 22;
        svg.line(picture::kMargin, y, picture::kWidth - picture::kMargin, y, "rule");
        y += 26;
        const std::string heading = line_heading(texts, project, plan.lines[i]);
        svg.text(picture::kMargin, y, "line",
                 text_within(heading, 15, picture::kWidth - 2 * picture::kMargin));
        y = picture::draw_timeline(svg, texts, project, plan.lines[i], y, most_bars, legend);
        y = picture::draw_comparison(svg, texts, comparisons[i], y);
    }
    draw_plan_legend(svg, texts, legend, legend_y);
    if (drawn < plan.lines.size()) {
        y += 30;
        svg.text(picture::kMargin, y, "caption",
                 texts("app.svg.more_lines", {{"count", std::to_string(plan.lines.size() - drawn)}}));
    }
    return svg.document({.width = picture::kWidth,
                         .height = y + picture::kMargin,
                         .language = page_language(texts.language()),
                         .title = title,
                         .style_sheet = kPlanStyleSheet});
}

}  // namespace takt::report
