#include "plans/timeline_strip.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "takt/report/drawing/formatting.hpp"
#include "takt/report/plans/plan_report.hpp"

namespace takt::report::picture {
namespace {

using plan::Bar;
using plan::Part;

constexpr std::size_t kMostStripRows = 64;
constexpr double kLeastTickDistance = 62;  // pixels
constexpr double kLeastWidthOfParts = 3;   // pixels of a bar that shows them
constexpr double kLeastWidthOfEdge = 12;   // pixels of a bar set off from the one before it
constexpr const char* kPartStyles[plan::kParts] = {"silence", "request", "turnaround", "response", "pause"};

/// 1, 2 or 5 times a power of ten, so that ticks keep their distance.
double tick_step(double milliseconds) {
    const double least = milliseconds / kPlotWidth * kLeastTickDistance;
    const double power = std::pow(10.0, std::floor(std::log10(least)));
    for (const double factor : {1.0, 2.0, 5.0})
        if (factor * power >= least) return factor * power;
    return 10 * power;
}

}  // namespace

std::string items_text(const plan::Request& request) {
    const std::string whole = request_text(request);
    return whole.substr(whole.find(' ') + 1);
}

Strip::Strip(Svg& svg, const Texts& texts, const model::Project& project, const plan::LinePlan& plan,
             const Shape& shape, std::span<const Bar> bars, double top)
    : svg_(svg),
      texts_(texts),
      project_(project),
      plan_(plan),
      line_(project.lines[plan.line]),
      shares_(plan::shares(line_, plan)),
      bars_(bars),
      shape_(shape),
      top_(top),
      axis_(top),
      scale_(kPlotWidth / std::max(ms(shape.end - shape.begin), 1e-6)) {
    std::set<std::size_t> drawn;
    for (const Bar& bar : bars) drawn.insert(plan.requests[bar.request].device);
    for (const auto& request : plan.requests) {
        if (rows_.size() == kMostStripRows || !drawn.erase(request.device)) continue;
        const std::size_t index = rows_.size();
        rows_[request.device].index = index;
    }
    left_out_ = drawn.size();
    axis_ = top_ + shape_.row_height * static_cast<double>(rows_.size()) + 4;
    draw_rows();
    draw_axis();
}

void Strip::draw_rows() {
    for (const auto& [index, row] : rows_) {
        const double y = top_ + shape_.row_height * static_cast<double>(row.index);
        if (row.index % 2 == 0) svg_.rect({kMargin, y, kWidth - 2 * kMargin, shape_.row_height}, "stripe");
        const auto& device = line_.devices[index];
        const std::string figures =
            fmt::format(" · {} · {}", device.address.value, percent_text(shares_.devices[index]));
        const std::string name =
            text_within(device.name, 12, kPlotLeft - kMargin - 12 - text_width(figures, 12)) + figures;
        svg_.text(kPlotLeft - 10, bar_top(row) + shape_.bar_height / 2 + 4, "row", name);
    }
}

void Strip::draw_axis() {
    const double step = tick_step(ms(shape_.end - shape_.begin));
    const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
    const double last = ms(shape_.end);
    for (double k = std::ceil(ms(shape_.begin) / step - 1e-9); k * step <= last + 1e-9; ++k) {
        const double at = kPlotLeft + (k * step - ms(shape_.begin)) * scale_;
        svg_.line(at, top_, at, axis_ + 4, "grid");
        const std::string label = fmt::format("{:.{}f}", k * step + 0.0, decimals);
        if (at + text_width(label, kSmall) / 2 < kWidth) svg_.text(at, axis_ + 17, "tick", label);
    }
    svg_.line(kPlotLeft, axis_, kPlotLeft + kPlotWidth, axis_, "axis");
    svg_.text(kPlotLeft - 24, axis_ + 17, "small caption end", texts_("app.svg.axis"));
}

double Strip::bar_top(const Row& row) const {
    const double y = top_ + shape_.row_height * static_cast<double>(row.index + 1);
    return y - shape_.bar_height - (shape_.row_height - shape_.bar_height) / (shape_.labels ? 6 : 2);
}

void Strip::highlight(Duration begin, Duration end) {
    svg_.rect({x(begin), top_ - 2, std::max((ms(end - begin)) * scale_, 2.0), axis_ - top_ + 2}, "zoom");
}

void Strip::draw(Legend& legend) {
    svg_.begin_group("strip", fmt::format(" data-strip=\"{}\" data-line=\"{}\"", shape_.name, plan_.line));
    for (const Bar& bar : bars_) {
        const auto found = rows_.find(plan_.requests[bar.request].device);
        if (found == rows_.end()) continue;
        Row& row = found->second;
        if (row.last) draw_bar(row, *row.last, x(bar.start), legend);
        row.last = nullptr;
        const double left = x(bar.start);
        const double right = std::min(x(bar.end()), kPlotLeft + kPlotWidth);
        if (right - left >= kLeastWidthOfParts) {
            draw_merged(row, legend);
            row.last = &bar;
            continue;
        }
        if (row.merged > 0 && left - row.merged_to >= 1) draw_merged(row, legend);
        if (row.merged++ == 0) row.merged_from = left;
        row.merged_to = std::max(right, left + 0.5);
    }
    for (auto& [device, row] : rows_) {
        draw_merged(row, legend);
        if (row.last) draw_bar(row, *row.last, kPlotLeft + kPlotWidth, legend);
    }
    svg_.end_group();
}

void Strip::draw_merged(Row& row, Legend& legend) {
    if (row.merged == 0) return;
    svg_.begin_group("bars", fmt::format(" data-count=\"{}\"", row.merged));
    svg_.title(texts_("app.svg.merged", {{"count", std::to_string(row.merged)}}));
    svg_.rect({row.merged_from, bar_top(row), row.merged_to - row.merged_from, shape_.bar_height}, "whole");
    svg_.end_group();
    legend.whole = true;
    row.merged = 0;
}

void Strip::draw_bar(const Row& row, const Bar& bar, double next, Legend& legend) {
    const auto& request = plan_.requests[bar.request];
    const double y = bar_top(row);
    const bool background = *request.period == Duration::zero();
    legend.background = legend.background || background;
    svg_.begin_group(background ? "bar background" : "bar",
                     fmt::format(" data-request=\"{}\" data-start-ns=\"{}\" data-end-ns=\"{}\"", bar.request,
                                 bar.start.count(), bar.end().count()));
    svg_.title(tooltip(bar));
    draw_parts(bar, y, legend);
    if (x(bar.end()) - x(bar.start) > kLeastWidthOfEdge)
        svg_.line(x(bar.start), y, x(bar.start), y + shape_.bar_height, "edge");
    if (bar.late) {
        const double right = std::min(x(bar.end()), kPlotLeft + kPlotWidth);
        svg_.rect({x(bar.start), y + shape_.bar_height, right - x(bar.start), 2.5}, "late");
        legend.late = true;
    }
    if (shape_.labels && !background)
        draw_label(request, x(bar.start), next - x(bar.start) - kLabelGap, y - 4);
    svg_.end_group();
}

void Strip::draw_parts(const Bar& bar, double y, Legend& legend) {
    const double edge = kPlotLeft + kPlotWidth;
    for (std::size_t i = 0; i < plan::kParts; ++i) {
        const auto part = static_cast<Part>(i);
        const double left = x(bar.begin_of(part));
        const double right = std::min(x(bar.end_of(part)), edge);
        const Duration length = bar.end_of(part) - bar.begin_of(part);
        if (length == Duration::zero() || left >= edge) continue;
        const double inset = part == Part::pause ? 0.5 : 0;
        svg_.rect(
            {left + inset, y + inset, std::max(right - left - 2 * inset, 0.0), shape_.bar_height - 2 * inset},
            kPartStyles[i], fmt::format(" data-ns=\"{}\"", length.count()));
        legend.pause = legend.pause || part == Part::pause;
    }
}

void Strip::draw_label(const plan::Request& request, double left, double available, double y) {
    for (const auto& label : {request_text(request), items_text(request)}) {
        if (text_width(label, kSmall) > available) continue;
        svg_.text(left, y, "small", label);
        return;
    }
}

std::string Strip::tooltip(const Bar& bar) const {
    const auto& request = plan_.requests[bar.request];
    const auto& device = line_.devices[request.device];
    std::string parts;
    for (std::size_t i = 0; i < plan::kParts; ++i) {
        const auto part = static_cast<Part>(i);
        const Duration length = bar.end_of(part) - bar.begin_of(part);
        if (length == Duration::zero()) continue;
        parts += (parts.empty() ? "" : ", ") + texts_(std::string("app.svg.") + kPartStyles[i]) + ' ' +
                 texts_.duration(length);
    }
    std::string text = fmt::format("{} {}  {}\n{}\n", device.name, device.address.value,
                                   request_text(request), variables_text(device, request));
    text += texts_("app.svg.sent", {{"when", when_text(texts_, project_, request)},
                                    {"due", texts_.duration(bar.due)},
                                    {"start", texts_.duration(bar.start)}});
    text += fmt::format("\n{} {}: {}\n{}: {}\n{}", texts_("app.bus_time"), texts_.duration(request.bus_time),
                        parts, texts_("app.share"), percent_text(shares_.requests[bar.request]),
                        texts_(request.why.code, request.why.arguments));
    return text;
}

}  // namespace takt::report::picture
