// The records of a request table, decoded (docs/formats/request-table.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>

namespace takt::table {

/// First bytes of an image in Takt's own format, and of an owen-kc1 export.
inline constexpr char kMagic[9] = "TAKTTABL";
inline constexpr char kOwenMagic[9] = "TAKT-KC1";
inline constexpr std::uint16_t kVersion = 3;  ///< of Takt's own format
inline constexpr std::uint16_t kOwenVersion = 1;
/// Longest image that is read.
inline constexpr std::size_t kMaxImage = std::size_t{256} << 20;

/// No index, no text.
inline constexpr std::uint32_t kNone = 0xFFFF'FFFF;

/// An array of records: the offset of the first in the image, and their number.
struct Section {
    std::uint32_t offset = 0;
    std::uint32_t count = 0;
};

/// Times are nanoseconds everywhere.
struct Header {
    std::uint16_t version = kVersion;
    std::uint16_t header_size = 0;
    std::uint32_t length = 0;       ///< of the whole image
    std::uint32_t checksum = 0;     ///< CRC-32 of the whole image with this field as 0
    std::uint32_t value_words = 0;  ///< 16-bit words the values of all items take
    std::uint32_t write_words = 0;  ///< words of the items that can be written
    Section lines, devices, entries, members, items, texts;  ///< of texts the count is bytes
};

/// One line. Its devices and its entries are contiguous.
struct LineRecord {
    std::uint8_t transport = 0;  ///< as model::Transport
    std::uint8_t framing = 0;    ///< as wire::Framing
    std::uint8_t order = 0;      ///< 0 deadline, 1 address
    std::uint8_t rs485 = 0;      ///< as model::Rs485
    std::uint8_t parity = 0;     ///< as wire::Parity
    std::uint8_t data_bits = 8;
    std::uint8_t stop_bits = 1;
    std::uint8_t echo = 0;  ///< as bus::Echo
    std::uint32_t baud = 0;
    std::uint16_t tcp_port = 0;
    std::uint16_t in_flight = 1;
    std::uint16_t command_burst = 1;
    std::int64_t command_interval = 0;
    std::int64_t frame_gap = 0;
    std::int64_t request_gap = 0;
    std::int64_t margin = 0;
    std::int64_t host_overhead = 0;  ///< part of the longest time of each transaction
    std::int64_t broadcast_turnaround = 0;
    std::int64_t frame_silence = 0;
    std::uint32_t first_device = 0, device_count = 0;
    std::uint32_t first_entry = 0, entry_count = 0;
    std::uint32_t name = kNone;  ///< text
    std::uint32_t port = kNone;  ///< text: device file, or host
    std::uint32_t request_count = 0;
    std::uint32_t ungrouped_requests = 0;
    std::int64_t cycle = 0;
    double utilization = 0;
};

/// One device. Its entries are contiguous.
struct DeviceRecord {
    static constexpr std::uint8_t kHighByteFirst = 0x01;
    static constexpr std::uint8_t kHighRegisterFirst = 0x02;
    static constexpr std::uint8_t kMaskWrite = 0x04;        ///< it has 0x16
    static constexpr std::uint8_t kReadWrite = 0x08;        ///< it has 0x17
    static constexpr std::uint8_t kReadModifyWrite = 0x10;  ///< bits may be written by reading their register
    static constexpr std::uint8_t kDerivedWait = 0x20;      ///< the wait comes from the turnaround

    std::uint32_t line = 0;
    std::uint8_t unit = 1;
    std::uint8_t flags = 0;
    std::uint8_t gaps = 0;  ///< as model::Gaps
    std::uint16_t attempts = 1;
    std::uint16_t in_flight = 1;
    std::int64_t period = 0;
    std::int64_t response_timeout = 0;
    std::int64_t wait = 0;         ///< longest time to the first byte of a response: bus::Transaction::wait
    std::int64_t turnaround = -1;  ///< -1: not known
    std::int64_t round_trip = 0;
    std::int64_t measured_longest = 0;  ///< longest response time measured; 0: not measured
    std::int64_t measured_exchanges = 0;
    std::uint16_t measured_in_flight = 1;  ///< 1..16
    std::int64_t backoff_first = 0;
    std::int64_t backoff_limit = 0;
    std::uint32_t status = kNone;       ///< item
    std::uint32_t poll_enable = kNone;  ///< item
    std::uint32_t first_entry = 0, entry_count = 0;
    std::uint32_t name = kNone;
};

/// One request: a read, a write, or both.
struct EntryRecord {
    static constexpr std::uint16_t kPolled = 0x01;  ///< by its period
    static constexpr std::uint16_t kWrittenOnChange = 0x04;
    static constexpr std::uint16_t kReadModifyWrite = 0x08;
    static constexpr std::uint16_t kHasDeadline = 0x10;  ///< stated in the plan; else it is the period
    static constexpr std::uint16_t kHasAdmission = 0x20;
    static constexpr std::uint16_t kInLongestRound = 0x40;  ///< of its line

    std::uint32_t device = 0;
    std::uint8_t read = 0;   ///< function, 0: nothing
    std::uint8_t write = 0;  ///< likewise
    std::uint16_t flags = 0;
    std::uint16_t start = 0;  ///< on the wire
    std::uint16_t quantity = 0;
    std::uint16_t write_start = 0;  ///< of 0x17
    std::uint16_t write_quantity = 0;
    std::int64_t period = 0;
    std::int64_t phase = 0;
    std::int64_t deadline = 0;  ///< relative to the release; orders polling
    std::uint32_t stream = 0;
    std::uint32_t read_trigger = kNone;   ///< item
    std::uint32_t write_trigger = kNone;  ///< item
    std::uint32_t status = kNone;         ///< item
    std::int64_t min_interval = 0;
    std::uint16_t burst = 1;
    std::uint32_t first_member = 0, member_count = 0;
    std::uint16_t request_bytes = 0, response_bytes = 0;
    std::int64_t bus_time = 0;
};

/// One value: a local, or a variable of a device. Locals come first, then the variables of each device in the
/// order of the project.
struct ItemRecord {
    static constexpr std::uint16_t kHighByteFirst = 0x01;
    static constexpr std::uint16_t kHighRegisterFirst = 0x02;
    static constexpr std::uint16_t kUsed = 0x04;
    static constexpr std::uint16_t kHoldLast = 0x08;
    static constexpr std::uint16_t kRetain = 0x10;
    static constexpr std::uint16_t kSafeToRepeat = 0x20;
    static constexpr std::uint16_t kHasDefault = 0x40;
    static constexpr std::uint16_t kWrittenOnChange = 0x80;
    static constexpr std::uint16_t kVerify = 0x100;
    static constexpr std::uint8_t kNoBit = 0xFF;

    std::uint32_t device = kNone;  ///< none: a local
    std::uint8_t type = 0;         ///< as DataType
    std::uint8_t area = 0;         ///< as wire::Area
    std::uint8_t bit = kNoBit;     ///< of a bool: 0..15
    std::uint8_t read = 0, write = 0;
    std::uint16_t flags = 0;
    std::uint16_t start = 0;  ///< on the wire: register, or coil
    std::uint16_t registers = 1;
    std::uint32_t place = 0;            ///< its first word among the values
    std::uint32_t write_place = kNone;  ///< its first word among what can be written
    std::uint64_t default_raw = 0;      ///< as in the words, the first in the lowest bits; not of strings
    double default_number = 0;          ///< the same as a number, scaled
    double scale = 1, offset = 0, dead_band = 0;
    std::int64_t period = 0;
    std::int64_t greatest_age = 0;  ///< of a good value: the proved one, else `max_age`; 0: none
    std::uint32_t read_trigger = kNone, write_trigger = kNone, status = kNone;  ///< items
    std::int64_t min_interval = 0;                                              ///< of its admission
    std::uint16_t burst = 0;                                                    ///< 0: no admission
    std::uint32_t default_text = kNone;
    std::uint32_t name = kNone;
    std::uint32_t unit = kNone;
};

/// Visits the fields of a record in the order of the image.
template <class Coder>
constexpr void code(Coder& c, Section& r) {
    c(r.offset), c(r.count);
}
template <class Coder>
constexpr void code(Coder& c, Header& r) {
    c(r.version), c(r.header_size), c(r.length), c(r.checksum), c(r.value_words), c(r.write_words);
    for (Section* section : {&r.lines, &r.devices, &r.entries, &r.members, &r.items, &r.texts})
        code(c, *section);
}
template <class Coder>
constexpr void code(Coder& c, LineRecord& r) {
    c(r.transport), c(r.framing), c(r.order), c(r.rs485), c(r.parity), c(r.data_bits), c(r.stop_bits),
        c(r.echo);
    c(r.baud), c(r.tcp_port), c(r.in_flight), c(r.command_burst), c(r.command_interval);
    c(r.frame_gap), c(r.request_gap), c(r.margin), c(r.host_overhead), c(r.broadcast_turnaround),
        c(r.frame_silence);
    c(r.first_device), c(r.device_count), c(r.first_entry), c(r.entry_count), c(r.name), c(r.port);
    c(r.request_count), c(r.ungrouped_requests), c(r.cycle), c(r.utilization);
}
template <class Coder>
constexpr void code(Coder& c, DeviceRecord& r) {
    c(r.line), c(r.unit), c(r.flags), c(r.gaps), c(r.attempts), c(r.in_flight);
    c(r.period), c(r.response_timeout), c(r.wait), c(r.turnaround), c(r.round_trip);
    c(r.measured_longest), c(r.measured_exchanges), c(r.measured_in_flight);
    c(r.backoff_first), c(r.backoff_limit);
    c(r.status), c(r.poll_enable), c(r.first_entry), c(r.entry_count), c(r.name);
}
template <class Coder>
constexpr void code(Coder& c, EntryRecord& r) {
    c(r.device), c(r.read), c(r.write), c(r.flags), c(r.start), c(r.quantity), c(r.write_start);
    c(r.write_quantity), c(r.period), c(r.phase), c(r.deadline), c(r.stream);
    c(r.read_trigger), c(r.write_trigger), c(r.status), c(r.min_interval), c(r.burst);
    c(r.first_member), c(r.member_count), c(r.request_bytes), c(r.response_bytes), c(r.bus_time);
}
template <class Coder>
constexpr void code(Coder& c, ItemRecord& r) {
    c(r.device), c(r.type), c(r.area), c(r.bit), c(r.read), c(r.write), c(r.flags), c(r.start),
        c(r.registers);
    c(r.place), c(r.write_place), c(r.default_raw), c(r.default_number), c(r.scale), c(r.offset);
    c(r.dead_band), c(r.period), c(r.greatest_age), c(r.read_trigger), c(r.write_trigger), c(r.status);
    c(r.min_interval), c(r.burst), c(r.default_text), c(r.name), c(r.unit);
}
/// A member of an entry (the index of an item), a byte of a text.
template <class Coder>
constexpr void code(Coder& c, std::uint32_t& member) {
    c(member);
}
template <class Coder>
constexpr void code(Coder& c, std::uint8_t& byte) {
    c(byte);
}

namespace internal {
struct Count {
    std::size_t bytes = 0;
    template <class T>
    constexpr void operator()(const T&) {
        bytes += sizeof(T);
    }
};
}  // namespace internal

/// Bytes of a record in the image.
template <class Record>
constexpr std::size_t record_size() {
    internal::Count count;
    Record record{};
    code(count, record);
    return count.bytes;
}

inline constexpr std::size_t kMagicSize = 8;
inline constexpr std::size_t kHeaderSize = kMagicSize + record_size<Header>();
/// The offsets of the length and of the checksum in the image, in both formats.
inline constexpr std::size_t kLengthOffset = kMagicSize + 4;
inline constexpr std::size_t kChecksumOffset = kMagicSize + 8;

}  // namespace takt::table
