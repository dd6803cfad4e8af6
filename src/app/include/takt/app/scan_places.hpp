// Where `takt scan` looks: lists of units and line settings, ranges of hosts, as written on the command line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/numbers.hpp"
#include "takt/base/result.hpp"
#include "takt/line/target.hpp"

namespace takt::app {

/// Reads "1-10,16,20-25"; each number once, in the order written.
/// @param name  of the option, the subject of errors
/// @returns syntax ("--units=…"), out_of_range (name, value, least, greatest)
[[nodiscard]] Result<std::vector<std::uint32_t>> parse_numbers(std::string_view name, std::string_view text,
                                                               std::uint32_t least, std::uint32_t greatest);

/// Reads "none,even,odd". @returns syntax with the word and those that are known
[[nodiscard]] Result<std::vector<wire::Parity>> parse_parities(std::string_view text);

/// What to try on serial lines; an empty list: what the target says, else the usual ones.
struct LineSettings {
    std::vector<std::uint32_t> bauds;
    std::vector<wire::Parity> parities;
    std::vector<std::uint32_t> stop_bits;
};

/// One port or host, and the settings to try there, the likely ones first; a host has one.
struct ScanPlace {
    std::vector<line::Target> settings;
    bool of_many = false;  ///< one host of a range: that nobody is there is no error
};

inline constexpr std::size_t kMaxScanPlaces = 4096;

/// The places a target names: tcp://10.0.0.1-20 and tcp://10.0.0.0/24 (without the network's first and last
/// address) are ranges of hosts.
/// @returns the errors of parse_target(); out_of_range for a range that is too large
[[nodiscard]] Result<std::vector<ScanPlace>> scan_places(std::string_view target,
                                                         const LineSettings& settings);

}  // namespace takt::app
