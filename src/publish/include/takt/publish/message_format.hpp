// The payloads of messages: JSON. docs/mqtt-messages.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "takt/host/snapshot.hpp"
#include "takt/publish/sample.hpp"

namespace takt::publish {

/// A sample with its place in the stream of its output. The pair of epoch and number identifies it.
struct PlacedSample {
    const Series* series = nullptr;
    const Sample* sample = nullptr;
    std::uint64_t number = 0;  ///< from 1 on; missing numbers are those of a gap
};

/// Samples that are missing, in their place in the stream.
struct MissingSamples {
    std::string_view cause;
    std::uint64_t samples = 0;
    std::uint64_t first_number = 0;  ///< of the first of them
    std::int64_t first_wall_ns = 0;
    std::int64_t last_wall_ns = 0;
};

/// One variable: its value with unit, quality, time and the interval of its change.
[[nodiscard]] std::string variable_message(const PlacedSample& sample, std::uint64_t epoch, bool repeated);

/// Variables of one device.
/// @param samples  at least one; each variable once
[[nodiscard]] std::string group_message(std::span<const PlacedSample> samples, std::uint64_t epoch,
                                        bool repeated);

[[nodiscard]] std::string gap_message(const MissingSamples& missing, std::uint64_t epoch, bool repeated);

/// Lines and devices with their states and counters.
/// @param snapshot  with statistics
[[nodiscard]] std::string status_message(const host::Snapshot& snapshot, std::int64_t wall_ns);

/// The birth and the will: whether the program delivers.
[[nodiscard]] std::string state_message(bool online);

}  // namespace takt::publish
