// The project that a heard line makes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "takt/capture/line_statistics.hpp"
#include "takt/model/line.hpp"

namespace takt::capture {

struct HeardProject {
    model::Line line;  ///< with the connection that it was given
    /// Of each device of the line: items without a variable.
    std::vector<std::size_t> left_out;
    /// Units that no device may have: 248 and above.
    std::vector<std::uint8_t> other_units;
};

inline constexpr std::size_t kMostVariables = 512;  ///< of a device

/// A device for each unit 1..247 that was asked and for the broadcasts that write (unit 0), and a variable of
/// 16 bits, or a coil, for each item that it was asked for. An item that the device refused is left out. The
/// period of a variable is that of its fastest poll; the device has the most frequent one. Also set: the
/// ranges that are read (`readable`), the longest read (`registers_per_request`), and a response time-out of
/// three times the longest response time where the default is too short; after enough responses
/// (model::MeasuredTimes::kEnough) the turnaround, a fifth more than the longest.
/// @param connection      the line without devices
/// @param stretch         all periods are that many times longer, 1..1000
/// @param most_variables  of a device, 1..kMostVariables; further items are left out
[[nodiscard]] HeardProject heard_project(const LineStatistics& statistics, const model::Line& connection,
                                         int stretch = 1, std::size_t most_variables = kMostVariables);

/// The number of devices of heard_project().
[[nodiscard]] std::size_t heard_devices(const LineStatistics& statistics);

/// A measured period as a user would have set it: 99.6 ms are 100 ms. At least 1 ms, at most a day.
[[nodiscard]] Duration nice_period(Duration measured);

}  // namespace takt::capture
