// The options that every program for many seeds has.
#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "takt/base/time.hpp"

namespace takt::seeds {

struct Options {
    std::uint64_t first = 1;
    std::uint64_t last = 1;
    double minutes = 10;  ///< of virtual time
    unsigned jobs = 1;
    std::string resume;  ///< file; empty: none
    bool json = false;
    bool trace = false;
    bool help = false;

    [[nodiscard]] Duration length() const;
};

template <class Number>
[[nodiscard]] bool parse_number(std::string_view text, Number& number) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc() && end == text.data() + text.size();
}

/// The option without a value that has this name; nullptr: none of these.
[[nodiscard]] bool* flag_of(std::string_view key, Options& options);

enum class Parsed : std::uint8_t {
    good,
    unknown,  ///< none of these options
    wrong,    ///< the value is not allowed
};
/// An option with a value. @param allowed  set if it is wrong
[[nodiscard]] Parsed parse_value(std::string_view key, std::string_view value, Options& options,
                                 std::string& allowed);

/// "--seeds 17 --minutes 5"
[[nodiscard]] std::string replay_arguments(const Options& options, std::uint64_t seed);

}  // namespace takt::seeds
