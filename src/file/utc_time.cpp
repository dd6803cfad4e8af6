#include "utc_time.hpp"

#include <fmt/format.h>

#include <array>

namespace takt::file {

std::string time_text(Seconds time) {
    const auto day = std::chrono::floor<std::chrono::days>(time);
    const std::chrono::year_month_day date(day);
    const std::chrono::hh_mm_ss clock(time - day);
    return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", static_cast<int>(date.year()),
                       static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                       clock.hours().count(), clock.minutes().count(), clock.seconds().count());
}

std::optional<Seconds> time_of(std::string_view text) {
    constexpr std::string_view kPattern = "0000-00-00T00:00:00Z";
    std::array<unsigned, 6> numbers{};
    if (text.size() != kPattern.size()) return std::nullopt;
    std::size_t number = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const bool digit = text[i] >= '0' && text[i] <= '9';
        if (kPattern[i] == '0' ? !digit : text[i] != kPattern[i]) return std::nullopt;
        if (digit)
            numbers[number] = 10 * numbers[number] + static_cast<unsigned>(text[i] - '0');
        else
            ++number;
    }
    const std::chrono::year_month_day date{std::chrono::year(static_cast<int>(numbers[0])),
                                           std::chrono::month(numbers[1]), std::chrono::day(numbers[2])};
    if (!date.ok() || numbers[3] > 23 || numbers[4] > 59 || numbers[5] > 59) return std::nullopt;
    return std::chrono::sys_days(date) + std::chrono::hours(numbers[3]) + std::chrono::minutes(numbers[4]) +
           std::chrono::seconds(numbers[5]);
}

}  // namespace takt::file
