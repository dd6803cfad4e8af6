#include "takt/report/times/history_svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "drawing/chart_layout.hpp"
#include "drawing/ticks.hpp"
#include "takt/report/drawing/svg.hpp"

namespace takt::report {
namespace {

constexpr double kHistoryPlotWidth = static_cast<double>(kHistorySvgPixels);
constexpr double kHistoryPageWidth = kChartLeft + kHistoryPlotWidth + kChartMargin;
constexpr double kHistoryPlotHeight = 180;
constexpr double kVariableHeadingHeight = 34;
constexpr double kHistoryAxisHeight = 40;
constexpr std::size_t kMostValueTicks = 5;
constexpr double kNarrowestBand = 1;  // pixels

// Colours of Okabe and Ito, which stay apart for every kind of colour vision.
constexpr std::string_view kHistoryStyleSheet = R"(.page{fill:#fff}
text{font-family:system-ui,"DejaVu Sans","Noto Sans",Arial,sans-serif;font-size:13px;fill:#1c2733}
.heading{font-size:19px;font-weight:600}
.name{font-size:15px;font-weight:600}
.small{font-size:11px}
.tick{font-size:11px;text-anchor:middle}
.value{font-size:11px;text-anchor:end}
.plot{fill:none;stroke:#7b8794;stroke-width:1}
.grid{stroke:#dde3e9;stroke-width:1}
.curve{fill:none;stroke:#0072b2;stroke-width:1.5;stroke-linejoin:round}
.band{fill:#0072b2;fill-opacity:.25}
.lost{fill:url(#lost)}
.dead{fill:url(#dead)}
.bad{fill:url(#bad)}
.lost-line{stroke:#7b8794;stroke-width:2}
.dead-line{stroke:#d55e00;stroke-width:2}
.bad-line{stroke:#cc79a7;stroke-width:2}
@media (prefers-color-scheme:dark){.page{fill:#14191f}text{fill:#e3e8ed}.grid{stroke:#2c3640}
.curve{stroke:#56b4e9}.band{fill:#56b4e9}}
)";

bool is_dead(const store::HistoryBadSpan& span) {
    using enum value::Reason;
    return span.reason == not_answering || span.reason == timeout || span.reason == link_lost ||
           span.reason == never_connected;
}

/// A time in which no value is drawn.
struct HistoryHole {
    store::HistoryRange range;
    std::string_view style;
    std::string title;
};

std::vector<HistoryHole> holes_of(const Texts& texts, const store::HistoryPicture& picture) {
    std::vector<HistoryHole> holes;
    for (const auto& gap : picture.gaps)
        holes.push_back({{gap.first_ns, gap.last_ns}, "lost", gap_text(texts, gap.cause)});
    for (const auto& span : picture.bad)
        if (span.quality != value::Quality::uncertain)
            holes.push_back(
                {span.range, is_dead(span) ? "dead" : "bad", texts.quality(span.quality, span.reason)});
    std::ranges::stable_sort(holes, {}, [](const HistoryHole& hole) { return hole.range.from_ns; });
    return holes;
}

/// The plot of one variable.
class HistoryPlot {
public:
    HistoryPlot(Svg& svg, const Texts& texts, const HistoryView& view, double top)
        : svg_(svg), view_(view), picture_(view.picture), holes_(holes_of(texts, view.picture)), top_(top) {
        least_ = picture_.min.value_or(0);
        greatest_ = picture_.max.value_or(1);
        const double edge =
            greatest_ > least_ ? (greatest_ - least_) * 0.06 : std::max(std::abs(least_) * 0.05, 0.5);
        least_ -= edge;
        greatest_ += edge;
    }

    void draw() {
        draw_grid();
        for (const HistoryHole& hole : holes_) draw_hole(hole);
        draw_curve();
        for (const auto& box : bands_) svg_.rect(box, "band");
        svg_.path(curve_, "curve");
        svg_.rect({kChartLeft, top_, kHistoryPlotWidth, kHistoryPlotHeight}, "plot");
    }

private:
    [[nodiscard]] double x(std::int64_t time_ns) const {
        const auto& range = picture_.range;
        const double share =
            static_cast<double>(time_ns - range.from_ns) / static_cast<double>(range.to_ns - range.from_ns);
        return kChartLeft + std::clamp(share, 0.0, 1.0) * kHistoryPlotWidth;
    }
    [[nodiscard]] double y(double value) const {
        return top_ + kHistoryPlotHeight - (value - least_) / (greatest_ - least_) * kHistoryPlotHeight;
    }

    void draw_grid() {
        for (const double value : value_ticks(least_, greatest_, kMostValueTicks)) {
            svg_.line(kChartLeft, y(value), kChartLeft + kHistoryPlotWidth, y(value), "grid");
            svg_.text(kChartLeft - 6, y(value) + 4, "value", fmt::format("{:.9g}", value));
        }
        for (const auto& [time, text] : time_ticks(picture_.range, kMostTimeTicks)) {
            const double half = text_width(text, kTickFontSize) / 2;
            svg_.line(x(time), top_, x(time), top_ + kHistoryPlotHeight, "grid");
            svg_.text(std::clamp(x(time), half, kHistoryPageWidth - half), top_ + kHistoryPlotHeight + 16,
                      "tick", text);
        }
    }

    void draw_hole(const HistoryHole& hole) {
        const double left = x(hole.range.from_ns);
        svg_.begin_group("hole");
        svg_.title(hole.title);
        svg_.rect({left, top_, std::max(x(hole.range.to_ns) - left, 1.0), kHistoryPlotHeight}, hole.style);
        svg_.end_group();
    }

    /// The time until which a value from `from` on holds, at most `to`.
    [[nodiscard]] std::int64_t hold_end(std::int64_t from, std::int64_t to) const {
        std::int64_t end = std::min(to, std::max(from, picture_.known_until_ns));
        for (const HistoryHole& hole : holes_)
            if (hole.range.from_ns >= from) end = std::min(end, hole.range.from_ns);
        return end;
    }

    void move_to(double to_x, double to_y) { curve_ += fmt::format("M{:.2f} {:.2f}", to_x, to_y); }

    /// Holds the last value until `time`. @returns whether it holds until then
    bool hold_until(std::int64_t time) {
        if (!holding_) return false;
        const std::int64_t end = hold_end(held_since_, time);
        curve_ += fmt::format("H{:.2f}", x(end));
        return end == time;
    }

    void step_to(const store::HistoryPoint& point) {
        if (hold_until(point.time_ns)) {
            add_band(point);
            curve_ += fmt::format("V{:.2f}", y(point.value));
        } else {
            move_to(x(point.time_ns), y(point.value));
        }
        holding_ = true;
        held_since_ = point.time_ns;
        held_value_ = point.value;
    }

    /// The change happened between the poll before and this one.
    void add_band(const store::HistoryPoint& point) {
        if (!point.previous_ns || point.value == held_value_) return;
        const double left = x(std::max(*point.previous_ns, picture_.range.from_ns));
        const double width = x(point.time_ns) - left;
        if (width < kNarrowestBand) return;
        const double upper = std::min(y(point.value), y(held_value_));
        bands_.push_back({left, upper, width, std::abs(y(point.value) - y(held_value_))});
    }

    void draw_curve() {
        if (picture_.held) {
            held_since_ = picture_.range.from_ns;
            held_value_ = picture_.held->value;
            holding_ = true;
            move_to(kChartLeft, y(held_value_));
        }
        for (const auto& pixel : picture_.pixels) {
            if (!pixel.has_value) continue;
            step_to(pixel.first);
            const bool min_first = pixel.min.time_ns <= pixel.max.time_ns;
            for (const auto* point :
                 {min_first ? &pixel.min : &pixel.max, min_first ? &pixel.max : &pixel.min, &pixel.last})
                if (point->time_ns > held_since_) step_to(*point);
        }
        hold_until(picture_.range.to_ns);
    }

    Svg& svg_;
    const HistoryView& view_;
    const store::HistoryPicture& picture_;
    std::vector<HistoryHole> holes_;
    double top_;
    double least_ = 0;
    double greatest_ = 1;
    std::string curve_;
    std::vector<Svg::Box> bands_;
    bool holding_ = false;
    std::int64_t held_since_ = 0;
    double held_value_ = 0;
};

std::string history_heading(const Texts& texts, const HistoryView& view) {
    const auto& [series, picture, last] = view;
    const auto number = [](std::optional<double> value) {
        return value ? fmt::format("{:.6g}", *value) : "–";
    };
    return series.name + (series.unit.empty() ? "" : ", " + series.unit) + ": " + texts("app.history.min") +
           ' ' + number(picture.min) + ", " + texts("app.history.mean") + ' ' + number(picture.mean) + ", " +
           texts("app.history.max") + ' ' + number(picture.max);
}

void draw_history_legend(Svg& svg, const Texts& texts, double y) {
    double x = kChartMargin;
    for (const char* style : {"lost", "dead", "bad", "band"}) {
        const std::string name = texts(std::string("app.history.legend.") + style);
        svg.rect({x, y - 11, 22, 13}, style);
        svg.text(x + 29, y, "", name);
        x += 29 + text_width(name, 13) + 16;
    }
}

}  // namespace

std::string history_svg(const Texts& texts, const std::string& title, const std::vector<HistoryView>& views) {
    Svg svg;
    svg.hatch("lost", 45, 7, "lost-line");
    svg.hatch("dead", 135, 7, "dead-line");
    svg.hatch("bad", 0, 5, "bad-line");
    double y = 38;
    svg.text(kChartMargin, y, "heading", text_within(title, 19, kHistoryPageWidth - 2 * kChartMargin));
    y += 30;
    draw_history_legend(svg, texts, y);
    for (const auto& view : views) {
        y += kVariableHeadingHeight;
        svg.text(kChartMargin, y, "name",
                 text_within(history_heading(texts, view), 15, kHistoryPageWidth - 2 * kChartMargin));
        y += 12;
        HistoryPlot(svg, texts, view, y).draw();
        y += kHistoryPlotHeight + kHistoryAxisHeight;
    }
    return svg.document({.width = kHistoryPageWidth,
                         .height = y + kChartMargin,
                         .language = page_language(texts.language()),
                         .title = title,
                         .style_sheet = kHistoryStyleSheet});
}

}  // namespace takt::report
