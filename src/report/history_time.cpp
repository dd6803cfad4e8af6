#include "takt/report/history_time.hpp"

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

std::int64_t whole_seconds(std::int64_t time_ns) {
    return time_ns / kNanosecondsPerSecond - (time_ns % kNanosecondsPerSecond < 0 ? 1 : 0);
}

std::int64_t milliseconds_of(std::int64_t time_ns) {
    return (time_ns - whole_seconds(time_ns) * kNanosecondsPerSecond) / 1'000'000;
}

std::tm local_fields(std::int64_t time_ns) {
    const auto seconds = static_cast<std::time_t>(whole_seconds(time_ns));
    std::tm fields{};
    ::localtime_r(&seconds, &fields);
    return fields;
}

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

/// Takes parts of a text from its beginning.
class TimeReader {
public:
    explicit TimeReader(std::string_view text) : text_(text) {}

    [[nodiscard]] bool at_end() const { return text_.empty(); }
    bool take(char wanted) {
        if (text_.empty() || text_.front() != wanted) return false;
        text_.remove_prefix(1);
        return true;
    }
    /// Exactly `digits` digits.
    std::optional<int> number(std::size_t digits) {
        int value = 0;
        if (text_.size() < digits) return std::nullopt;
        for (const char c : text_.substr(0, digits)) {
            if (c < '0' || c > '9') return std::nullopt;
            value = value * 10 + (c - '0');
        }
        text_.remove_prefix(digits);
        return value;
    }
    /// Digits behind a point, in ns.
    std::optional<std::int64_t> fraction() {
        std::int64_t value = 0;
        std::int64_t unit = kNanosecondsPerSecond / 10;
        std::size_t count = 0;
        for (; !text_.empty() && text_.front() >= '0' && text_.front() <= '9'; ++count, unit /= 10) {
            value += (text_.front() - '0') * unit;
            text_.remove_prefix(1);
        }
        return count > 0 ? std::optional(value) : std::nullopt;
    }

private:
    std::string_view text_;
};

struct Clock {
    std::chrono::year_month_day day;
    int hour = 0;
    int minute = 0;
    int second = 0;
    std::int64_t fraction_ns = 0;
};

std::optional<Clock> parse_clock(TimeReader& in) {
    const auto year = in.number(4);
    if (!year || !in.take('-')) return std::nullopt;
    const auto month = in.number(2);
    if (!month || !in.take('-')) return std::nullopt;
    const auto day = in.number(2);
    if (!day) return std::nullopt;
    Clock clock;
    clock.day = std::chrono::year(*year) / std::chrono::month(static_cast<unsigned>(*month)) /
                std::chrono::day(static_cast<unsigned>(*day));
    if (!clock.day.ok() || *year < 1700 || *year > 2250) return std::nullopt;
    if (in.at_end()) return clock;
    if (!in.take('T') && !in.take(' ')) return std::nullopt;
    const auto hour = in.number(2);
    if (!hour || *hour > 23 || !in.take(':')) return std::nullopt;
    const auto minute = in.number(2);
    if (!minute || *minute > 59) return std::nullopt;
    clock.hour = *hour;
    clock.minute = *minute;
    if (!in.take(':')) return clock;
    const auto second = in.number(2);
    if (!second || *second > 59) return std::nullopt;
    clock.second = *second;
    if (!in.take('.')) return clock;
    const auto fraction = in.fraction();
    if (!fraction) return std::nullopt;
    clock.fraction_ns = *fraction;
    return clock;
}

/// In seconds. A local time that the change to summer time leaves out is rejected.
std::optional<std::int64_t> local_seconds(const Clock& clock) {
    std::tm fields{};
    fields.tm_year = static_cast<int>(clock.day.year()) - 1900;
    fields.tm_mon = static_cast<int>(static_cast<unsigned>(clock.day.month())) - 1;
    fields.tm_mday = static_cast<int>(static_cast<unsigned>(clock.day.day()));
    fields.tm_hour = clock.hour;
    fields.tm_min = clock.minute;
    fields.tm_sec = clock.second;
    fields.tm_isdst = -1;
    const std::time_t seconds = std::mktime(&fields);
    if (fields.tm_hour != clock.hour || fields.tm_min != clock.minute) return std::nullopt;
    return std::int64_t{seconds};
}

}  // namespace

std::optional<std::int64_t> parse_history_time(std::string_view text, std::int64_t now_ns) {
    if (text == "now") return now_ns;
    if (text.starts_with('-')) return parse_span(text.substr(1), now_ns);
    TimeReader in(text);
    const auto clock = parse_clock(in);
    if (!clock) return std::nullopt;
    if (in.at_end()) {
        const auto seconds = local_seconds(*clock);
        return seconds ? std::optional(*seconds * kNanosecondsPerSecond + clock->fraction_ns) : std::nullopt;
    }
    const std::int64_t utc =
        std::chrono::sys_days(clock->day).time_since_epoch().count() * std::int64_t{86'400} +
        clock->hour * std::int64_t{3600} + clock->minute * std::int64_t{60} + clock->second;
    std::int64_t offset = 0;
    if (!in.take('Z')) {
        const bool west = in.take('-');
        if (!west && !in.take('+')) return std::nullopt;
        const auto hours = in.number(2);
        in.take(':');
        const auto minutes = in.number(2);
        if (!hours || !minutes || *hours > 23 || *minutes > 59) return std::nullopt;
        offset = (west ? -1 : 1) * (*hours * std::int64_t{3600} + *minutes * std::int64_t{60});
    }
    if (!in.at_end()) return std::nullopt;
    return (utc - offset) * kNanosecondsPerSecond + clock->fraction_ns;
}

std::string utc_time_text(std::int64_t time_ns) {
    const auto seconds = static_cast<std::time_t>(whole_seconds(time_ns));
    return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(seconds), milliseconds_of(time_ns));
}

std::string local_time_text(std::int64_t time_ns) {
    const std::tm fields = local_fields(time_ns);
    const std::string offset = fmt::format("{:%z}", fields);  // "+0200"
    return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}{}:{}", fields, milliseconds_of(time_ns),
                       offset.substr(0, 3), offset.substr(3));
}

std::string short_time_text(std::int64_t time_ns, std::int64_t reference_ns) {
    const std::tm fields = local_fields(time_ns);
    const std::tm reference = local_fields(reference_ns);
    const bool same_day = fields.tm_yday == reference.tm_yday && fields.tm_year == reference.tm_year;
    return same_day ? fmt::format("{:%H:%M:%S}", fields) : fmt::format("{:%Y-%m-%d %H:%M:%S}", fields);
}

}  // namespace takt::report
