// Draws at most two strips: the whole round, and its first burst enlarged.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <span>

#include "plans/timeline_strip.hpp"
#include "takt/report/drawing/formatting.hpp"

namespace takt::report::picture {
namespace {

using plan::Bar;

constexpr std::size_t kLegibleBars = 26;  // side by side, each with its label
constexpr std::size_t kFewBars = 10;

/// The number of bars too narrow for a label, when these bars fill the width of the page.
std::size_t without_label(const plan::LinePlan& plan, std::span<const Bar> bars) {
    const double scale = kPlotWidth / ms(bars.back().end() - bars.front().start);
    std::map<std::size_t, Duration> next;  // by device: the begin of the next bar
    std::size_t count = 0;
    for (std::size_t i = bars.size(); i-- > 0;) {
        const auto& request = plan.requests[bars[i].request];
        const Duration end = next.try_emplace(request.device, bars.back().end()).first->second;
        if (text_width(items_text(request), kSmall) > ms(end - bars[i].start) * scale - kLabelGap) ++count;
        next[request.device] = bars[i].start;
    }
    return count;
}

/// The number of bars, from the first on, that form a burst: no long idle time between them, and few enough
/// to label.
std::size_t first_burst(const plan::LinePlan& plan, std::span<const Bar> bars) {
    constexpr std::size_t kLeast = 3;
    std::size_t count = 1;
    for (; count < std::min(bars.size(), kLegibleBars); ++count) {
        const Duration idle = bars[count].start - bars[count - 1].end();
        const Duration so_far = bars[count - 1].end() - bars[0].start;
        if (count >= kLeast && idle > so_far / 4) break;
    }
    while (count > kFewBars && without_label(plan, bars.first(count)) > 0) --count;
    return count;
}

std::string caption_of(const Texts& texts, const plan::LinePlan& plan, const plan::RoundWindow& round,
                       const plan::Timeline& timeline) {
    if (timeline.cut)
        return texts("app.svg.cut", {{"count", std::to_string(timeline.bars.size())},
                                     {"time", texts.duration(timeline.bars.back().end())}});
    if (plan.utilization > 1) return texts("app.svg.overrun", {{"time", texts.duration(round.length)}});
    if (round.repeats == Duration::zero()) return texts("app.svg.endless");
    if (!round.whole)
        return texts(round.repeats == Duration::max() ? "app.svg.no_repeat" : "app.svg.part",
                     {{"time", texts.duration(round.length)}, {"repeats", texts.duration(round.repeats)}});
    return texts("app.svg.repeats", {{"repeats", texts.duration(round.repeats)}});
}

}  // namespace

double draw_timeline(Svg& svg, const Texts& texts, const model::Project& project, const plan::LinePlan& plan,
                     double top, std::size_t most_bars, Legend& legend) {
    const auto round = plan::round_window(plan);
    const auto timeline = plan::timeline(project.lines[plan.line], plan, round.length, most_bars);
    const std::span<const Bar> bars = timeline.bars;
    double y = top + 22;
    if (bars.empty()) {
        svg.text(kMargin, y, "caption", texts("app.svg.nothing"));
        return y;
    }
    svg.text(kMargin, y, "caption", caption_of(texts, plan, round, timeline));
    y += 10;
    const Duration end = timeline.cut ? bars.back().end() : round.length;
    const std::size_t burst = first_burst(plan, bars);
    Strip::Shape enlarged{bars[0].start, bars[burst - 1].end(), 32, 13, true, "enlarged"};
    if (burst == bars.size() && (enlarged.end - enlarged.begin) * 2 > end) {
        enlarged.begin = Duration::zero();
        enlarged.end = std::max(end, enlarged.end);
    } else {
        Strip whole(svg, texts, project, plan, {Duration::zero(), end, 18, 11, false, "round"}, bars, y);
        whole.highlight(enlarged.begin, enlarged.end);
        whole.draw(legend);
        y = whole.bottom() + 20;
        if (whole.left_out() > 0) {
            svg.text(kMargin, y, "caption",
                     texts("app.svg.more_devices", {{"count", std::to_string(whole.left_out())}}));
            y += 20;
        }
        svg.text(kMargin, y, "caption",
                 texts("app.svg.enlarged", {{"begin", fmt::format("{:.4g}", ms(enlarged.begin))},
                                            {"end", texts.duration(enlarged.end)}}));
        y += 10;
    }
    Strip strip(svg, texts, project, plan, enlarged, bars.first(burst), y);
    strip.draw(legend);
    return strip.bottom();
}

}  // namespace takt::report::picture
