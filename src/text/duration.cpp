#include "takt/text/duration.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "takt/text/catalogue.hpp"

namespace takt::text {
namespace {

using namespace std::chrono_literals;

std::string quantity(Language language, std::string number, std::string_view unit) {
    return std::move(number.append(" ").append(pattern(language, std::string("unit.").append(unit))));
}

/// The number of units with `digits` decimals.
std::string decimal(Duration duration, Duration unit, std::size_t digits) {
    std::int64_t scale = 1;
    for (std::size_t i = 0; i < digits; ++i) scale *= 10;
    auto text = std::to_string((duration.count() * scale + unit.count() / 2) / unit.count());
    if (digits == 0) return text;
    text.insert(0, digits + 1 - std::min(digits + 1, text.size()), '0');
    return text.insert(text.size() - digits, 1, '.');
}

/// With three significant digits from 0.1 to 1000 units.
std::string three_digits(Language language, Duration duration, Duration unit, std::string_view name) {
    const bool none = duration * 10'000 < unit * 9995;
    const bool one = duration * 1000 < unit * 9995;
    const bool two = duration * 1000 < unit * 99'950;
    return quantity(language, decimal(duration, unit, none ? 3 : one ? 2 : two ? 1 : 0), name);
}

std::string whole_parts(Language language, std::int64_t large, std::string_view large_unit,
                        std::int64_t small, std::string_view small_unit) {
    auto text = quantity(language, std::to_string(large), large_unit);
    return small == 0 ? text : text + ' ' + quantity(language, std::to_string(small), small_unit);
}

}  // namespace

std::string duration_text(Language language, Duration duration) {
    if (duration < 0s) return '-' + duration_text(language, -duration);
    if (duration == 0s) return quantity(language, "0", "ms");
    if (duration < 100us) return three_digits(language, duration, 1us, "us");
    const std::int64_t seconds = duration / 1s;
    if (duration >= 1h) return whole_parts(language, seconds / 3600, "h", seconds / 60 % 60, "min");
    if (duration >= 1min) return whole_parts(language, seconds / 60, "min", seconds % 60, "s");
    if (duration % 1s == 0s) return quantity(language, std::to_string(seconds), "s");
    if (duration >= 10s) return three_digits(language, duration, 1s, "s");
    return three_digits(language, duration, 1ms, "ms");
}

Duration rounded_up(Duration duration) {
    if (duration <= 0s) return duration;
    const auto up = [duration](Duration step) { return (duration + step - 1ns) / step * step; };
    if (duration > 1h) return up(1min);
    if (duration > 1min) return up(1s);
    if (duration > 10s) return up(100ms);
    const Duration unit = duration < 100us ? Duration(1us) : Duration(1ms);
    return up(duration <= unit         ? unit / 1000
              : duration <= 10 * unit  ? unit / 100
              : duration <= 100 * unit ? unit / 10
                                       : unit);
}

std::string with_local_unit(Language language, std::string_view text) {
    const auto end = text.find_first_not_of("0123456789.");
    if (end == 0 || !text.substr(std::min(end, text.size())).starts_with(' ')) return std::string(text);
    const auto unit = pattern(language, std::string("unit.").append(text.substr(end + 1)));
    if (unit.empty()) return std::string(text);
    return std::string(text.substr(0, end + 1)).append(unit);
}

}  // namespace takt::text
