// The records of a request table of the profile owen-kc1 (docs/formats/request-table.md), and a view of them
// in the bytes of an image.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "takt/base/data_type.hpp"
#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
#include "takt/table/bytes.hpp"
#include "takt/table/format.hpp"

namespace takt::table {

/// A place in the controller's value buffer: one value each, numbered from 1; first the locals of the project
/// in its order, then the variables of each device in the order in which they are read, then those that are
/// only written. 0: none.
using Place = std::uint16_t;

struct OwenHeader {
    std::uint16_t version = kOwenVersion;
    std::uint16_t header_size = 0;
    std::uint32_t length = 0;
    std::uint32_t checksum = 0;
    std::uint16_t places = 0;  ///< in the value buffer
    std::uint16_t masters = 0;
    std::uint16_t devices = 0;
    std::uint16_t entries = 0;
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

struct OwenDevice {
    static constexpr std::uint8_t kHighByteFirst = 0x01;
    static constexpr std::uint8_t kHighRegisterFirst = 0x02;

    std::uint8_t unit = 1;
    std::uint8_t orders = 0;
    std::uint16_t period_ms = 0;
    std::uint16_t timeout_ms = 0;
    std::uint16_t attempts = 0;
    Place status = 0, poll_enable = 0;
    std::uint16_t first_entry = 0, entry_count = 0;

    friend bool operator==(const OwenDevice&, const OwenDevice&) = default;
};

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

    [[nodiscard]] std::uint8_t kind() const { return type_and_bit & 15; }
    [[nodiscard]] std::uint8_t bit() const { return type_and_bit >> 4; }

    friend bool operator==(const OwenEntry&, const OwenEntry&) = default;
};

/// Visits the fields of a record in the order of the image.
template <class Coder>
constexpr void code(Coder& c, OwenHeader& r) {
    c(r.version), c(r.header_size), c(r.length), c(r.checksum);
    c(r.places), c(r.masters), c(r.devices), c(r.entries);
}
template <class Coder>
constexpr void code(Coder& c, OwenMaster& r) {
    c(r.framing), c(r.parity), c(r.data_bits), c(r.stop_bits), c(r.baud), c(r.request_gap_us);
    c(r.frame_gap_us), c(r.first_device), c(r.device_count);
}
template <class Coder>
constexpr void code(Coder& c, OwenDevice& r) {
    c(r.unit), c(r.orders), c(r.period_ms), c(r.timeout_ms), c(r.attempts), c(r.status), c(r.poll_enable);
    c(r.first_entry), c(r.entry_count);
}
template <class Coder>
constexpr void code(Coder& c, OwenEntry& r) {
    c(r.type_and_bit), c(r.read), c(r.write), c(r.flags), c(r.quantity), c(r.start), c(r.data);
    c(r.read_trigger), c(r.write_trigger), c(r.status), c(r.period_ms);
}

inline constexpr std::size_t kOwenHeaderSize = kMagicSize + record_size<OwenHeader>();
static_assert(record_size<OwenEntry>() == 20 && record_size<OwenDevice>() == 16 &&
              record_size<OwenMaster>() == 20 && kOwenHeaderSize == 28);

/// An image of owen-kc1 that was checked: devices and entries belong to one owner each, and places are in the
/// buffer. Never allocates; copies are cheap. The bytes must outlive it and must not change.
class OwenView {
public:
    /// @returns what View::open() returns
    [[nodiscard]] static Result<OwenView> open(Bytes image);

    [[nodiscard]] const OwenHeader& header() const { return header_; }
    /// The index is less than the count.
    [[nodiscard]] OwenMaster master(std::size_t index) const { return record<OwenMaster>(0, index); }
    [[nodiscard]] OwenDevice device(std::size_t index) const {
        return record<OwenDevice>(devices_at(), index);
    }
    [[nodiscard]] OwenEntry entry(std::size_t index) const { return record<OwenEntry>(entries_at(), index); }

private:
    explicit OwenView(Bytes image) : image_(image) {}
    [[nodiscard]] Result<void> check() const;

    [[nodiscard]] std::size_t devices_at() const { return header_.masters * record_size<OwenMaster>(); }
    [[nodiscard]] std::size_t entries_at() const {
        return devices_at() + header_.devices * record_size<OwenDevice>();
    }
    template <class Record>
    [[nodiscard]] Record record(std::size_t offset, std::size_t index) const {
        Record result{};
        Take take(image_.data() + kOwenHeaderSize + offset + index * record_size<Record>());
        code(take, result);
        return result;
    }

    Bytes image_;
    OwenHeader header_;
};

/// Whether the image, checked or not, begins as one of owen-kc1.
[[nodiscard]] bool is_owen(Bytes image);

/// The bytes that expand() needs.
[[nodiscard]] std::size_t expanded_size(const OwenView& table);

/// Writes the table in Takt's own format, so that one executor runs both. Item i is at place i + 1. A word is
/// an int16 and a double word an int32, because an entry has neither signs nor floats; locals are bools,
/// those of statuses int16. Entries with functions that no controller has are left out. The line is polled in
/// rounds by address, and a silent device is asked once each period. Nothing has a name.
/// @returns the image, at the begin of `into`; too_short (size, needed); overflow (needed, kMaxImage);
///          malformed ("entry", its index) if two entries disagree about the variable of a place
[[nodiscard]] Result<Bytes> expand(const OwenView& table, std::span<std::uint8_t> into);

}  // namespace takt::table
