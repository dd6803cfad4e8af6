#include "drawing/ticks.hpp"

#include <array>
#include <cmath>

#include "takt/report/times/history_time.hpp"

namespace takt::report {
namespace {

constexpr std::int64_t kMinute = 60;
constexpr std::int64_t kHour = 60 * kMinute;
constexpr std::int64_t kDay = 24 * kHour;
constexpr std::array kTimeSteps{
    std::int64_t{1}, std::int64_t{2}, std::int64_t{5}, std::int64_t{10}, std::int64_t{15}, std::int64_t{30},
    kMinute,         2 * kMinute,     5 * kMinute,     10 * kMinute,     15 * kMinute,     30 * kMinute,
    kHour,           2 * kHour,       3 * kHour,       6 * kHour,        12 * kHour,       kDay,
    2 * kDay,        7 * kDay,        28 * kDay,       91 * kDay,        364 * kDay};

std::int64_t offset_from_utc(std::int64_t time_ns) {
    return local_fields(time_ns).tm_gmtoff * kNanosecondsPerSecond;
}

std::int64_t step_for(std::int64_t length_ns, std::size_t most) {
    for (const std::int64_t step : kTimeSteps)
        if (length_ns / (step * kNanosecondsPerSecond) <= static_cast<std::int64_t>(most))
            return step * kNanosecondsPerSecond;
    return kTimeSteps.back() * kNanosecondsPerSecond;
}

double value_step(double length, std::size_t most) {
    const double least = length / static_cast<double>(most);
    const double decade = std::pow(10, std::floor(std::log10(least)));
    for (const double factor : {1.0, 2.0, 5.0})
        if (factor * decade >= least) return factor * decade;
    return 10 * decade;
}

}  // namespace

std::vector<double> value_ticks(double least, double greatest, std::size_t most) {
    std::vector<double> ticks;
    const double step = value_step(greatest - least, most);
    if (!std::isnormal(step)) return ticks;
    for (double number = std::ceil(least / step); number * step <= greatest && ticks.size() <= most; ++number)
        ticks.push_back(number == 0 ? 0 : number * step);
    return ticks;
}

std::vector<TimeTick> time_ticks(const store::HistoryRange& range, std::size_t most) {
    const std::int64_t step = step_for(range.to_ns - range.from_ns, most);
    const std::int64_t offset = offset_from_utc(range.from_ns);
    const std::int64_t since = (range.from_ns + offset) % step;
    std::int64_t time = range.from_ns + (since == 0 ? 0 : step - since);
    std::vector<TimeTick> ticks;
    std::int64_t before = INT64_MIN;
    for (; time <= range.to_ns && ticks.size() <= most; before = time, time += step) {
        auto text = short_time_text(time, before);
        if (step >= kMinute * kNanosecondsPerSecond) text.resize(text.size() - 3);  // without seconds
        ticks.push_back({time, std::move(text)});
    }
    return ticks;
}

}  // namespace takt::report
