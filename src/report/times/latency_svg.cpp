#include "takt/report/times/latency_svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "drawing/chart_layout.hpp"
#include "drawing/ticks.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/svg.hpp"
#include "times/latency_parts.hpp"

namespace takt::report {
namespace {

constexpr double kLatencyPlotWidth = 1000;
constexpr double kLatencyPlotHeight = 240;
constexpr double kLatencyPageWidth = kChartLeft + kLatencyPlotWidth + kChartMargin;
constexpr double kLatencyAxisHeight = 46;
constexpr std::size_t kHistogramBars = 250;
constexpr double kLeastUs = 0.1;   // left end of a logarithmic axis for times of zero
constexpr double kBelowOne = 0.5;  // the count at the foot of a bar, so that a single exchange is visible

// Colours of Okabe and Ito, which stay apart for every kind of colour vision.
constexpr std::string_view kLatencyStyleSheet = R"(.page{fill:#fff}
text{font-family:system-ui,"DejaVu Sans","Noto Sans",Arial,sans-serif;font-size:13px;fill:#1c2733}
.heading{font-size:19px;font-weight:600}
.name{font-size:15px;font-weight:600}
.tick{font-size:11px;text-anchor:middle}
.value{font-size:11px;text-anchor:end}
.mark{font-size:11px;text-anchor:middle}
.plot{fill:none;stroke:#7b8794;stroke-width:1}
.grid{stroke:#dde3e9;stroke-width:1}
.bar{fill:#0072b2}
.band{stroke:#56b4e9;stroke-width:1.2}
.mean{fill:none;stroke:#0072b2;stroke-width:1.5}
.percentile{stroke:#e69f00;stroke-width:1}
.limit{stroke:#d55e00;stroke-width:2}
@media (prefers-color-scheme:dark){.page{fill:#14191f}text{fill:#e3e8ed}.grid{stroke:#2c3640}
.bar{fill:#56b4e9}.mean{stroke:#f0f4f8}}
)";

double positive_us(Duration time) {
    return std::max(static_cast<double>(time.count()) / 1e3, kLeastUs);
}

Duration of_us(double value) {
    return Duration(std::llround(value * 1e3));
}

/// 1, 2 and 5 times powers of ten, or powers alone over more than three decades.
std::vector<double> log_ticks(double least, double greatest) {
    std::vector<double> ticks;
    const bool few = greatest / least > 1e3;
    for (double decade = std::pow(10, std::floor(std::log10(least))); decade <= greatest; decade *= 10)
        for (const double factor : {1.0, 2.0, 5.0})
            if (const double tick = decade * factor;
                tick >= least && tick <= greatest && (factor == 1 || !few))
                ticks.push_back(tick);
    return ticks;
}

/// A logarithmic axis from `least` to `greatest` to 0..1.
struct LogAxis {
    double least = 1;
    double greatest = 10;
    [[nodiscard]] double share(double value) const {
        return std::clamp(std::log(value / least) / std::log(greatest / least), 0.0, 1.0);
    }
    [[nodiscard]] double at(double share) const { return least * std::pow(greatest / least, share); }
};

LogAxis latency_axis(const capture::LatencyReport& report) {
    const auto& times = report.total().times;
    double greatest = positive_us(times.max());
    if (report.config().limit) greatest = std::max(greatest, positive_us(*report.config().limit));
    return {positive_us(times.min()) / 1.1, greatest * 1.1};
}

class LatencyPicture {
public:
    LatencyPicture(const Texts& texts, const LatencyRun& run)
        : texts_(texts), run_(run), axis_(latency_axis(run.report)) {}

    [[nodiscard]] std::string draw() {
        const std::string title = texts_("app.latency.title", {{"file", run_.file}});
        svg_.text(kChartMargin, 38, "heading", text_within(title, 19, kLatencyPageWidth - 2 * kChartMargin));
        double y = 68;
        svg_.text(kChartMargin, y, "", text_within(summary(), 13, kLatencyPageWidth - 2 * kChartMargin));
        if (run_.report.total().times.count() > 0) {
            y = draw_histogram(y + 34);
            y = draw_time_line(y + 34);
        }
        return svg_.document({.width = kLatencyPageWidth,
                              .height = y + kChartMargin,
                              .language = page_language(texts_.language()),
                              .title = title,
                              .style_sheet = kLatencyStyleSheet});
    }

private:
    [[nodiscard]] std::string summary() const {
        if (run_.report.config().limit) return latency_verdict_text(texts_, run_.report);
        return fmt::format("{}: {}", texts_("app.latency.answered"),
                           grouped_number(run_.report.total().answered, texts_.language()));
    }

    [[nodiscard]] double x(double value) const { return kChartLeft + axis_.share(value) * kLatencyPlotWidth; }

    [[nodiscard]] std::array<std::uint64_t, kHistogramBars> bars() const {
        std::array<std::uint64_t, kHistogramBars> counts{};
        const auto& times = run_.report.total().times;
        for (std::size_t i = 0; i < capture::BlockHistogram::kBuckets; ++i) {
            const auto bucket = times.histogram().bucket(i);
            if (bucket.count == 0) continue;
            const double middle =
                (positive_us(bucket.lower) + positive_us(std::min(bucket.upper, times.max()))) / 2;
            counts[std::min(static_cast<std::size_t>(axis_.share(middle) * kHistogramBars),
                            kHistogramBars - 1)] += bucket.count;
        }
        return counts;
    }

    double draw_histogram(double top) {
        svg_.text(kChartMargin, top, "name", texts_("app.latency.histogram"));
        top += 26;
        const double bottom = top + kLatencyPlotHeight;
        const auto counts = bars();
        const LogAxis height{kBelowOne, static_cast<double>(*std::ranges::max_element(counts)) * 1.2};
        const auto y = [&](double count) { return bottom - height.share(count) * kLatencyPlotHeight; };
        for (const double count : log_ticks(1, height.greatest)) {
            svg_.line(kChartLeft, y(count), kChartLeft + kLatencyPlotWidth, y(count), "grid");
            svg_.text(kChartLeft - 6, y(count) + 4, "value",
                      grouped_number(static_cast<std::uint64_t>(count), texts_.language()));
        }
        for (const double value : log_ticks(axis_.least, axis_.greatest)) {
            svg_.line(x(value), top, x(value), bottom, "grid");
            svg_.text(x(value), bottom + 16, "tick", texts_.duration(of_us(value)));
        }
        const double width = kLatencyPlotWidth / kHistogramBars;
        for (std::size_t i = 0; i < kHistogramBars; ++i) {
            if (counts[i] == 0) continue;
            const double bar_top = y(static_cast<double>(counts[i]));
            svg_.rect({kChartLeft + static_cast<double>(i) * width, bar_top, width, bottom - bar_top}, "bar",
                      fmt::format(" data-count=\"{}\"", counts[i]));
        }
        draw_marks(top, bottom);
        svg_.rect({kChartLeft, top, kLatencyPlotWidth, kLatencyPlotHeight}, "plot");
        return bottom + kLatencyAxisHeight;
    }

    /// Percentiles, each unless its label would cover the one before, and the limit.
    void draw_marks(double top, double bottom) {
        double free_from = 0;
        const auto mark = [&](double value, const char* style, const std::string& label) {
            svg_.line(x(value), top, x(value), bottom, style);
            const double half = text_width(label, kTickFontSize) / 2;
            if (x(value) - half < free_from) return;
            svg_.text(x(value), top - 4, "mark", label);
            free_from = x(value) + half + 4;
        };
        for (const auto& [name, percent] : kPercentiles)
            mark(positive_us(run_.report.total().times.percentile(percent)), "percentile", std::string(name));
        mark(positive_us(run_.report.total().times.max()), "percentile", texts_("app.latency.max"));
        if (run_.report.config().limit)
            svg_.line(x(positive_us(*run_.report.config().limit)), top,
                      x(positive_us(*run_.report.config().limit)), bottom, "limit");
    }

    double draw_time_line(double top) {
        svg_.text(kChartMargin, top, "name", texts_("app.latency.time_line"));
        top += 16;
        const double bottom = top + kLatencyPlotHeight;
        const auto& line = run_.report.time_line();
        const auto y = [&](Duration time) {
            return bottom - axis_.share(positive_us(time)) * kLatencyPlotHeight;
        };
        const auto column = [&](std::size_t index) {
            return kChartLeft +
                   (static_cast<double>(index) + 0.5) / static_cast<double>(line.size()) * kLatencyPlotWidth;
        };
        for (const double value : log_ticks(axis_.least, axis_.greatest)) {
            const double at = bottom - axis_.share(value) * kLatencyPlotHeight;
            svg_.line(kChartLeft, at, kChartLeft + kLatencyPlotWidth, at, "grid");
            svg_.text(kChartLeft - 6, at + 4, "value", texts_.duration(of_us(value)));
        }
        draw_times_of_day(line, top, bottom);
        std::string mean;
        for (std::size_t i = 0; i < line.size(); ++i) {
            if (line[i].count == 0) continue;
            svg_.line(column(i), y(line[i].min) + 0.5, column(i), y(line[i].max) - 0.5, "band");
            const Duration middle(static_cast<std::int64_t>(line[i].sum_ns / line[i].count));
            mean += fmt::format("{}{:.2f} {:.2f}", mean.empty() ? 'M' : 'L', column(i), y(middle));
        }
        svg_.path(mean, "mean");
        if (run_.report.config().limit)
            svg_.line(kChartLeft, y(*run_.report.config().limit), kChartLeft + kLatencyPlotWidth,
                      y(*run_.report.config().limit), "limit");
        svg_.rect({kChartLeft, top, kLatencyPlotWidth, kLatencyPlotHeight}, "plot");
        return bottom + kLatencyAxisHeight;
    }

    void draw_times_of_day(const capture::TimeLine& line, double top, double bottom) {
        const auto length = line.width_ns() * static_cast<std::int64_t>(line.size());
        for (const auto& [time, text] :
             time_ticks({line.begin_ns(), line.begin_ns() + length}, kMostTimeTicks)) {
            const double at = kChartLeft + static_cast<double>(time - line.begin_ns()) /
                                               static_cast<double>(length) * kLatencyPlotWidth;
            const double half = text_width(text, kTickFontSize) / 2;
            svg_.line(at, top, at, bottom, "grid");
            svg_.text(std::clamp(at, half, kLatencyPageWidth - half), bottom + 16, "tick", text);
        }
    }

    const Texts& texts_;
    const LatencyRun& run_;
    LogAxis axis_;
    Svg svg_;
};

}  // namespace

std::string latency_svg(const Texts& texts, const LatencyRun& run) {
    return LatencyPicture(texts, run).draw();
}

}  // namespace takt::report
