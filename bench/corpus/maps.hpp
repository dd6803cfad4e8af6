// Register maps to plan: real ones from a file, or made from a seed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "takt/model/project.hpp"

namespace corpus {

using takt::Duration;

/// One value as it lies in a device.
struct Value {
    int function = 3;         ///< 1 to 4
    std::uint32_t start = 0;  ///< on the wire
    std::uint32_t items = 1;  ///< registers, or one bit
    Duration period{};
    bool written = false;  ///< by 0x10 or 0x0F, on change

    [[nodiscard]] std::uint32_t end() const { return start + items; }
    [[nodiscard]] bool is_bit() const { return function <= 2; }
};

struct Map {
    std::string name;
    std::optional<std::uint32_t> most_registers;  ///< of a request, where the device says so
    bool has_periods = false;                     ///< values come with periods of their own
    std::vector<Value> values;
};

/// A file of one JSON object a line: device, max_regs, variables [{fc, write_fc, address, count, poll_ms}].
/// Values without a read function, beyond 65535 or longer than a request are left out.
[[nodiscard]] std::vector<Map> load(const std::string& path);

/// Maps as devices have them: runs of values, holes of all sizes, several areas.
[[nodiscard]] std::vector<Map> made_up(std::size_t count, std::uint64_t seed);

/// The same maps with periods drawn from those given.
[[nodiscard]] std::vector<Map> with_periods(std::vector<Map> maps, const std::vector<Duration>& periods,
                                            std::uint64_t seed);

struct Bus {
    takt::wire::Framing framing = takt::wire::Framing::rtu;
    std::uint32_t baud = 19200;  ///< 8E1, ASCII 7E1
    Duration turnaround{};       ///< on TCP: the round trip
};

/// One line with one device that has the map. @param gaps  whether it may be read in between
[[nodiscard]] takt::model::Project project_of(const Map& map, const Bus& bus, takt::model::Gaps gaps);

}  // namespace corpus
