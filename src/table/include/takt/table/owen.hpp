// The request table of a controller of the profile owen-kc1 (docs/specification.md, section 6): exactly its
// entries.
#pragma once

#include <cstdint>
#include <vector>

#include "takt/base/data_type.hpp"
#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
#include "takt/model/findings.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/table/build.hpp"
#include "takt/table/format.hpp"

namespace takt::table {

/// A place in the controller's value buffer: one value each, numbered from 1; first the locals of the project
/// in its order, then the variables of each device in the order in which they are read, then those that are
/// only written. 0: none.
using Place = std::uint16_t;

struct OwenEntry {
    static constexpr std::uint8_t kPolled = 0x01;
    static constexpr std::uint8_t kWrittenOnChange = 0x04;
    static constexpr std::uint8_t kBit = 0, kWord = 1, kDoubleWord = 2;
    static constexpr std::uint32_t kPeriodOfDevice = 0xFFFF'FFFF;

    std::uint8_t type_and_bit = 0;  ///< type in the low nibble, bit number in the high one
    std::uint8_t read = 0, write = 0;
    std::uint8_t flags = 0;
    std::uint16_t quantity = 0;  ///< variables
    std::uint16_t start = 0;     ///< register of the first one
    Place data = 0;              ///< of the first one; the others follow
    Place read_trigger = 0, write_trigger = 0, status = 0;
    std::uint32_t period_ms = kPeriodOfDevice;

    /// bool, int16 or int32: an entry distinguishes neither signs nor floats. Of an entry of read_owen().
    [[nodiscard]] DataType type() const;

    friend bool operator==(const OwenEntry&, const OwenEntry&) = default;
};

struct OwenDevice {
    std::uint8_t unit = 1;
    std::uint8_t orders = 0;  ///< 0x01 high byte first, 0x02 high register first
    std::uint16_t period_ms = 0;
    std::uint16_t timeout_ms = 0;
    std::uint16_t attempts = 0;
    Place status = 0, poll_enable = 0;
    std::uint16_t first_entry = 0, entry_count = 0;

    friend bool operator==(const OwenDevice&, const OwenDevice&) = default;
};

/// One line.
struct OwenMaster {
    std::uint8_t framing = 0;  ///< 0 RTU, 1 ASCII
    std::uint8_t parity = 0;   ///< 0 none, 1 even, 2 odd
    std::uint8_t data_bits = 8, stop_bits = 1;
    std::uint32_t baud = 0;
    std::uint32_t request_gap_us = 0, frame_gap_us = 0;
    std::uint16_t first_device = 0, device_count = 0;

    friend bool operator==(const OwenMaster&, const OwenMaster&) = default;
};

struct OwenTable {
    std::uint16_t version = kOwenVersion;
    std::uint16_t places = 0;  ///< in the value buffer
    std::vector<OwenMaster> masters;
    std::vector<OwenDevice> devices;
    std::vector<OwenEntry> entries;

    friend bool operator==(const OwenTable&, const OwenTable&) = default;
};

/// The table of a project, and everything that it cannot hold: each an error with the name of the
/// variable (of the first one of a request) and its location in the project; codes `table.…`. With errors the
/// table is of no use. Variables that no entry writes are a warning for each device.
struct OwenBuilt {
    OwenTable table;
    std::vector<model::Finding> findings;
};
[[nodiscard]] OwenBuilt build_owen(const model::Project& project, const plan::Plan& plan);

[[nodiscard]] Image write_owen(const OwenTable& table);

/// @returns what View::open() returns
[[nodiscard]] Result<OwenTable> read_owen(Bytes image);

/// The codes of OwenBuilt::findings.
[[nodiscard]] std::span<const std::string_view> owen_codes();

}  // namespace takt::table
