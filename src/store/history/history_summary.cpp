#include "history/history_summary.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

namespace takt::store {
namespace {

double seconds(std::int64_t from_ns, std::int64_t to_ns) {
    return static_cast<double>(to_ns - from_ns) / kNanosecondsPerSecond;
}

}  // namespace

std::optional<double> drawn_number(const HistorySample& sample) {
    if (sample.quality != value::Quality::good && sample.quality != value::Quality::uncertain) return {};
    if (const auto* const real = std::get_if<double>(&sample.value))
        return std::isfinite(*real) ? std::optional(*real) : std::nullopt;
    if (const auto* const integer = std::get_if<std::int64_t>(&sample.value))
        return static_cast<double>(*integer);
    if (const auto* const integer = std::get_if<std::uint64_t>(&sample.value))
        return static_cast<double>(*integer);
    if (const auto* const bit = std::get_if<bool>(&sample.value)) return *bit ? 1 : 0;
    return {};
}

std::int64_t hold_end(std::int64_t from_ns, std::int64_t to_ns, std::span<const HistoryGap> gaps) {
    const auto gap = std::ranges::lower_bound(gaps, from_ns, {}, &HistoryGap::first_ns);
    return gap == gaps.end() ? to_ns : std::min(to_ns, gap->first_ns);
}

HistorySummary summary_of(const HistorySample& sample) {
    HistorySummary summary{.begin_ns = sample.time_ns,
                           .end_ns = sample.time_ns,
                           .samples = 1,
                           .quality = sample.quality,
                           .reason = sample.reason,
                           .ends_good = sample.quality == value::Quality::good};
    if (const auto number = drawn_number(sample)) {
        summary.numbers = 1;
        summary.first = {sample.time_ns, *number, sample.previous_ns};
        summary.min = summary.max = summary.last = summary.first;
        summary.ends_with_number = true;
    }
    return summary;
}

void append(HistorySummary& summary, const HistorySummary& next, std::span<const HistoryGap> gaps) {
    const double held = seconds(summary.end_ns, hold_end(summary.end_ns, next.begin_ns, gaps));
    if (summary.ends_with_number) {
        summary.area += summary.last.value * held;
        summary.drawn_s += held;
    }
    if (summary.ends_good) summary.good_s += held;
    summary.area += next.area;
    summary.drawn_s += next.drawn_s;
    summary.good_s += next.good_s;
    summary.mixed =
        summary.mixed || next.mixed || next.quality != summary.quality || next.reason != summary.reason;
    if (next.numbers > 0) {
        if (summary.numbers == 0) {
            summary.first = next.first;
            summary.min = next.min;
            summary.max = next.max;
        }
        if (next.min.value < summary.min.value) summary.min = next.min;
        if (next.max.value > summary.max.value) summary.max = next.max;
        summary.last = next.last;
    }
    summary.numbers += next.numbers;
    summary.samples += next.samples;
    summary.end_ns = next.end_ns;
    summary.ends_good = next.ends_good;
    summary.ends_with_number = next.ends_with_number;
}

HistorySummary summary_of(std::span<const HistorySample> samples, std::span<const HistoryGap> gaps) {
    HistorySummary summary = summary_of(samples.front());
    for (const auto& sample : samples.subspan(1)) append(summary, summary_of(sample), gaps);
    return summary;
}

}  // namespace takt::store
