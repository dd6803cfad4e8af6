#include "takt/report/times/history_time.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <ctime>

namespace takt::report {
namespace {

constexpr double kMostSpan = 8e18;  // ns, 250 years

std::optional<std::int64_t> parse_span(std::string_view text, std::int64_t now_ns) {
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || !(number >= 0)) return std::nullopt;
    const std::string_view unit(end, static_cast<std::size_t>(text.data() + text.size() - end));
    struct Unit {
        std::string_view name;
        double seconds;
    };
    constexpr std::array<Unit, 7> kUnits{
        {{"ms", 0.001}, {"s", 1}, {"m", 60}, {"min", 60}, {"h", 3600}, {"d", 86'400}, {"w", 604'800}}};
    for (const auto& [name, seconds] : kUnits) {
        const double span = number * seconds * static_cast<double>(kNanosecondsPerSecond);
        if (unit == name && span < kMostSpan) return now_ns - static_cast<std::int64_t>(span);
    }
    return std::nullopt;
}

/// A local time that the change to summer time leaves out is rejected.
std::optional<std::int64_t> local_ns(const WrittenTime& time) {
    const std::chrono::hh_mm_ss clock(std::chrono::floor<std::chrono::seconds>(time.since_midnight));
    std::tm fields{};
    fields.tm_year = static_cast<int>(time.day.year()) - 1900;
    fields.tm_mon = static_cast<int>(static_cast<unsigned>(time.day.month())) - 1;
    fields.tm_mday = static_cast<int>(static_cast<unsigned>(time.day.day()));
    fields.tm_hour = static_cast<int>(clock.hours().count());
    fields.tm_min = static_cast<int>(clock.minutes().count());
    fields.tm_sec = static_cast<int>(clock.seconds().count());
    fields.tm_isdst = -1;
    const std::time_t seconds = std::mktime(&fields);
    if (fields.tm_hour != clock.hours().count() || fields.tm_min != clock.minutes().count())
        return std::nullopt;
    const auto fraction = time.since_midnight - clock.to_duration();
    return seconds * kNanosecondsPerSecond + std::chrono::nanoseconds(fraction).count();
}

}  // namespace

std::optional<std::int64_t> parse_history_time(std::string_view text, std::int64_t now_ns) {
    if (text == "now") return now_ns;
    if (text.starts_with('-')) return parse_span(text.substr(1), now_ns);
    const auto time = read_time(text);
    if (!time) return std::nullopt;
    return time->offset ? std::optional(time->utc_ns()) : local_ns(*time);
}

std::tm local_fields(std::int64_t time_ns) {
    const std::chrono::sys_time<std::chrono::nanoseconds> time{std::chrono::nanoseconds(time_ns)};
    const std::time_t seconds = std::chrono::floor<std::chrono::seconds>(time).time_since_epoch().count();
    std::tm fields{};
    ::localtime_r(&seconds, &fields);
    return fields;
}

std::string local_time_text(std::int64_t time_ns) {
    return offset_time_text(time_ns, std::chrono::seconds(local_fields(time_ns).tm_gmtoff));
}

std::string short_time_text(std::int64_t time_ns, std::int64_t reference_ns) {
    const std::tm fields = local_fields(time_ns);
    const std::tm reference = local_fields(reference_ns);
    const bool same_day = fields.tm_yday == reference.tm_yday && fields.tm_year == reference.tm_year;
    return same_day ? fmt::format("{:%H:%M:%S}", fields) : fmt::format("{:%Y-%m-%d %H:%M:%S}", fields);
}

}  // namespace takt::report
