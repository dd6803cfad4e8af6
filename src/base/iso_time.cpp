#include "takt/base/iso_time.hpp"

#include <array>
#include <cstdio>

#include "takt/base/ascii.hpp"

namespace takt {
namespace {

using namespace std::chrono;

constexpr int kLongestFraction = 9;

sys_time<nanoseconds> instant(std::int64_t time_ns) {
    return sys_time<nanoseconds>{nanoseconds(time_ns)};
}

int milliseconds_of(std::int64_t time_ns) {
    const auto time = instant(time_ns);
    return static_cast<int>(floor<milliseconds>(time - floor<seconds>(time)).count());
}

/// Takes parts of a text from its beginning.
class Parts {
public:
    explicit Parts(std::string_view text) : rest_(text) {}

    [[nodiscard]] bool at_end() const { return rest_.empty(); }
    bool take(std::string_view any) {
        if (rest_.empty() || any.find(rest_.front()) == std::string_view::npos) return false;
        rest_.remove_prefix(1);
        return true;
    }
    /// Two digits, or as many as are asked for, not above `most`.
    std::optional<int> number(int most, std::size_t digits = 2) {
        const auto text = rest_.substr(0, digits);
        if (text.size() < digits || !all_digits(text)) return std::nullopt;
        int value = 0;
        for (const char c : text) value = value * 10 + (c - '0');
        rest_.remove_prefix(digits);
        return value <= most ? std::optional(value) : std::nullopt;
    }
    /// Digits behind the point.
    std::optional<nanoseconds> fraction() {
        std::int64_t unit = kNanosecondsPerSecond;
        nanoseconds value{};
        int digits = 0;
        for (; !rest_.empty() && is_digit(rest_.front()); ++digits) {
            unit /= 10;
            value += nanoseconds((rest_.front() - '0') * unit);
            rest_.remove_prefix(1);
        }
        return digits > 0 && digits <= kLongestFraction ? std::optional(value) : std::nullopt;
    }

private:
    std::string_view rest_;
};

std::optional<year_month_day> read_day(Parts& parts) {
    const auto year = parts.number(2250, 4);
    if (!year || *year < 1700 || !parts.take("-")) return std::nullopt;
    const auto month = parts.number(12);
    if (!month || !parts.take("-")) return std::nullopt;
    const auto day = parts.number(31);
    if (!day) return std::nullopt;
    const year_month_day date{std::chrono::year(*year), std::chrono::month(static_cast<unsigned>(*month)),
                              std::chrono::day(static_cast<unsigned>(*day))};
    return date.ok() ? std::optional(date) : std::nullopt;
}

/// Hours and minutes.
std::optional<minutes> read_clock(Parts& parts) {
    const auto hour = parts.number(23);
    if (!hour || !parts.take(":")) return std::nullopt;
    const auto minute = parts.number(59);
    return minute ? std::optional(minutes(*hour * 60 + *minute)) : std::nullopt;
}

bool read_seconds(Parts& parts, WrittenTime& time) {
    const auto second = parts.number(59);
    if (!second) return false;
    time.since_midnight += seconds(*second);
    if (!parts.take(".")) return true;
    const auto fraction = parts.fraction();
    time.since_midnight += fraction.value_or(nanoseconds{});
    return fraction.has_value();
}

bool read_offset(Parts& parts, WrittenTime& time) {
    if (parts.take("Zz")) {
        time.offset = minutes(0);
        return true;
    }
    const bool west = parts.take("-");
    if (!west && !parts.take("+")) return false;
    time.offset = read_clock(parts);
    if (time.offset && west) time.offset = -*time.offset;
    return time.offset.has_value();
}

}  // namespace

std::string utc_time_text(std::int64_t time_ns, Fraction fraction) {
    const auto day = floor<days>(instant(time_ns));
    const year_month_day date(day);
    const hh_mm_ss clock(floor<seconds>(instant(time_ns) - day));
    std::array<char, 48> text{};
    const int length =
        std::snprintf(text.data(), text.size(), "%04d-%02u-%02uT%02d:%02d:%02d",
                      static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                      static_cast<unsigned>(date.day()), static_cast<int>(clock.hours().count()),
                      static_cast<int>(clock.minutes().count()), static_cast<int>(clock.seconds().count()));
    std::string made(text.data(), static_cast<std::size_t>(length));
    if (fraction == Fraction::none) return made + 'Z';
    std::snprintf(text.data(), text.size(), ".%03dZ", milliseconds_of(time_ns));
    return made + text.data();
}

std::string offset_time_text(std::int64_t time_ns, seconds offset) {
    auto text = utc_time_text(time_ns + nanoseconds(offset).count());
    const auto past = duration_cast<minutes>(offset < seconds(0) ? -offset : offset).count();
    std::array<char, 16> zone{};
    std::snprintf(zone.data(), zone.size(), "%c%02d:%02d", offset < seconds(0) ? '-' : '+',
                  static_cast<int>(past / 60), static_cast<int>(past % 60));
    text.pop_back();
    return text + zone.data();
}

std::int64_t WrittenTime::utc_ns() const {
    const nanoseconds midnight = sys_days(day).time_since_epoch();
    return (midnight + since_midnight - offset.value_or(minutes(0))).count();
}

std::optional<WrittenTime> read_time(std::string_view text) {
    Parts parts(text);
    const auto day = read_day(parts);
    if (!day) return std::nullopt;
    WrittenTime time;
    time.day = *day;
    if (parts.at_end()) {
        time.is_complete = false;
        return time;
    }
    time.is_complete = !parts.take(" ");
    if (time.is_complete && !parts.take("Tt")) return std::nullopt;
    const auto clock = read_clock(parts);
    if (!clock) return std::nullopt;
    time.since_midnight = *clock;
    const bool has_seconds = parts.take(":");
    time.is_complete = time.is_complete && has_seconds;
    if (has_seconds && !read_seconds(parts, time)) return std::nullopt;
    if (!parts.at_end() && (!read_offset(parts, time) || !parts.at_end())) return std::nullopt;
    return time;
}

std::optional<std::int64_t> read_utc_time(std::string_view text) {
    const auto time = read_time(text);
    if (!time || !time->is_complete || !time->offset) return std::nullopt;
    if (time->day.year() < 1970y || time->day.year() > 2199y) return std::nullopt;
    return time->utc_ns();
}

}  // namespace takt
