#include "options.hpp"

#include <cmath>
#include <cstdio>

namespace takt::seeds {
namespace {

constexpr double kMostMinutes = 100'000;
constexpr unsigned kMostJobs = 256;

bool parse_range(std::string_view text, Options& options) {
    const auto dots = text.find("..");
    if (!parse_number(text.substr(0, dots), options.first)) return false;
    options.last = options.first;
    if (dots != std::string_view::npos && !parse_number(text.substr(dots + 2), options.last)) return false;
    return options.first <= options.last;
}

}  // namespace

Duration Options::length() const {
    return Duration(std::llround(minutes * 60e9));
}

bool* flag_of(std::string_view key, Options& options) {
    if (key == "--json") return &options.json;
    if (key == "--trace") return &options.trace;
    if (key == "--help" || key == "-h") return &options.help;
    return nullptr;
}

Parsed parse_value(std::string_view key, std::string_view value, Options& options, std::string& allowed) {
    const auto outcome = [&](bool good, std::string_view what) {
        if (!good) allowed = what;
        return good ? Parsed::good : Parsed::wrong;
    };
    if (key == "--seeds") return outcome(parse_range(value, options), "a number, or a range like 1..300");
    if (key == "--minutes")
        return outcome(
            parse_number(value, options.minutes) && options.minutes > 0 && options.minutes <= kMostMinutes,
            "above 0, at most 100000");
    if (key == "--jobs")
        return outcome(parse_number(value, options.jobs) && options.jobs >= 1 && options.jobs <= kMostJobs,
                       "1..256");
    if (key != "--resume") return Parsed::unknown;
    options.resume = value;
    return Parsed::good;
}

std::string replay_arguments(const Options& options, std::uint64_t seed) {
    char minutes[32];
    std::snprintf(minutes, sizeof minutes, "%g", options.minutes);
    return "--seeds " + std::to_string(seed) + " --minutes " + minutes;
}

}  // namespace takt::seeds
