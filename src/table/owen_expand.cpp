// A table of owen-kc1 as records of Takt's own format, written in place: locals, then what the entries say
// about the places of the value buffer, then the words of the places. Each member of an entry is visited
// once.
#include <algorithm>
#include <chrono>
#include <initializer_list>
#include <string_view>

#include "takt/bus/transaction.hpp"
#include "takt/table/owen_view.hpp"
#include "takt/table/view.hpp"
#include "takt/wire/silence.hpp"

namespace takt::table {

using namespace std::string_view_literals;
namespace {

using namespace std::chrono_literals;

// How many writes go ahead of polling that is due: that of a project's line which says nothing.
constexpr Duration kCommandInterval = 250ms;

// The functions that an entry of a controller has; others make no request.
bool is_usable(const OwenEntry& entry) {
    const auto known = [](std::uint8_t code, std::initializer_list<std::uint8_t> codes) {
        return code == 0 || std::ranges::find(codes, code) != codes.end();
    };
    return known(entry.read, {1, 2, 3, 4}) && known(entry.write, {5, 6, 15, 16}) &&
           (entry.read != 0 || entry.write != 0);
}

wire::Area area_of(const OwenEntry& entry) {
    return wire::area_of(wire::Function{entry.read != 0 ? entry.read : entry.write});
}

std::int64_t nanoseconds(Duration time) {
    return time.count();
}

Duration period_of(const OwenDevice& device, const OwenEntry& entry) {
    return std::chrono::milliseconds(entry.period_ms == OwenEntry::kPeriodOfDevice ? device.period_ms
                                                                                   : entry.period_ms);
}

// One bit for each order, the same in a device and in an item.
std::uint8_t orders_of(const OwenDevice& device) {
    constexpr std::uint8_t kBoth = OwenDevice::kHighByteFirst | OwenDevice::kHighRegisterFirst;
    static_assert(DeviceRecord::kHighByteFirst == OwenDevice::kHighByteFirst &&
                  DeviceRecord::kHighRegisterFirst == OwenDevice::kHighRegisterFirst &&
                  ItemRecord::kHighByteFirst == OwenDevice::kHighByteFirst &&
                  ItemRecord::kHighRegisterFirst == OwenDevice::kHighRegisterFirst);
    return device.orders & kBoth;
}

struct Counts {
    std::uint64_t entries = 0, members = 0;
    std::uint32_t locals = 0;
};

Counts count(const OwenView& table) {
    Counts counts{.locals = table.header().places};
    for (std::size_t i = 0; i < table.header().entries; ++i) {
        const auto entry = table.entry(i);
        counts.locals = std::min(counts.locals, std::uint32_t{entry.data} - 1);
        if (!is_usable(entry)) continue;
        ++counts.entries;
        counts.members += entry.quantity;
    }
    return counts;
}

std::uint64_t size_of(const OwenView& table, const Counts& counts) {
    const auto& header = table.header();
    return kHeaderSize + header.masters * record_size<LineRecord>() +
           header.devices * record_size<DeviceRecord>() + counts.entries * record_size<EntryRecord>() +
           counts.members * record_size<std::uint32_t>() + header.places * record_size<ItemRecord>();
}

/// Where Put writes.
struct End {
    std::uint8_t* next;
    void push_back(std::uint8_t byte) { *next++ = byte; }
};

class Expansion {
public:
    Expansion(const OwenView& table, const Counts& counts, std::span<std::uint8_t> into)
        : table_(table), locals_(counts.locals), into_(into) {
        header_.header_size = static_cast<std::uint16_t>(kHeaderSize);
        std::size_t next = kHeaderSize;
        const auto lay_out = [&next](Section& section, std::uint64_t number, std::size_t size) {
            section = {static_cast<std::uint32_t>(next), static_cast<std::uint32_t>(number)};
            next += section.count * size;
        };
        lay_out(header_.lines, table.header().masters, record_size<LineRecord>());
        lay_out(header_.devices, table.header().devices, record_size<DeviceRecord>());
        lay_out(header_.entries, counts.entries, record_size<EntryRecord>());
        lay_out(header_.members, counts.members, record_size<std::uint32_t>());
        lay_out(header_.items, table.header().places, record_size<ItemRecord>());
        lay_out(header_.texts, 0, 1);
    }

    Result<void> write() {
        ItemRecord local{.area = static_cast<std::uint8_t>(wire::Area::holding_register),
                         .flags = ItemRecord::kUsed | ItemRecord::kHighByteFirst};
        for (std::uint32_t i = 0; i < header_.items.count; ++i) put(header_.items, i, local);
        for (std::uint32_t i = 0; i < header_.lines.count; ++i) TAKT_CHECK(add_line(i));
        place_items();
        std::copy_n(kMagic, kMagicSize, into_.begin());
        End end{into_.data() + kMagicSize};
        Put put_header(end);
        code(put_header, header_);
        seal(into_);
        return {};
    }

private:
    template <class Record>
    void put(const Section& section, std::uint32_t index, Record& record) {
        End end{into_.data() + section.offset + index * record_size<Record>()};
        Put coder(end);
        code(coder, record);
    }
    [[nodiscard]] ItemRecord item(std::uint32_t index) const {
        ItemRecord result;
        Take take(into_.data() + header_.items.offset + index * record_size<ItemRecord>());
        code(take, result);
        return result;
    }
    /// The item of a local at that place.
    [[nodiscard]] std::uint32_t local(Place place) const {
        return place >= 1 && place <= locals_ ? place - 1U : kNone;
    }

    std::uint32_t add_status(Place place) {
        const auto index = local(place);
        if (index == kNone) return kNone;
        auto record = item(index);
        record.type = static_cast<std::uint8_t>(DataType::int16);
        put(header_.items, index, record);
        return index;
    }

    Result<void> add_line(std::uint32_t index) {
        const auto master = table_.master(index);
        const bus::LineConfig usual;
        LineRecord line;
        line.framing =
            static_cast<std::uint8_t>(master.framing == 1 ? wire::Framing::ascii : wire::Framing::rtu);
        line.order = 1;
        line.parity = master.parity;
        line.data_bits = master.data_bits;
        line.stop_bits = master.stop_bits;
        line.echo = static_cast<std::uint8_t>(usual.echo);
        line.baud = master.baud;
        line.command_interval = nanoseconds(kCommandInterval);
        line.frame_gap = nanoseconds(std::chrono::microseconds(master.frame_gap_us));
        line.request_gap = nanoseconds(std::chrono::microseconds(master.request_gap_us));
        line.margin = nanoseconds(usual.margin);
        line.broadcast_turnaround = nanoseconds(usual.broadcast_turnaround);
        line.first_device = master.first_device;
        line.device_count = master.device_count;
        line.first_entry = entries_;
        bus_ = {.framing = wire::Framing{line.framing},
                .format = {line.baud, line.data_bits, wire::Parity{line.parity}, line.stop_bits},
                .frame_gap = Duration(line.frame_gap)};
        load_ = 0;
        for (std::uint32_t i = 0; i < master.device_count; ++i)
            TAKT_CHECK(add_device(index, master.first_device + i));
        line.entry_count = line.request_count = entries_ - line.first_entry;
        // For the order it only matters whether the line is overloaded. A division would cost a controller 2
        // KB.
        line.utilization = load_ > kWholeLoad ? 2 : 0;
        put(header_.lines, index, line);
        return {};
    }

    Result<void> add_device(std::uint32_t line, std::uint32_t index) {
        const auto owen = table_.device(index);
        const Duration timeout = std::chrono::milliseconds(owen.timeout_ms);
        // A silent device is asked once each period, as docs/specification.md, section 13, has it.
        const Duration pause = std::max<Duration>(std::chrono::milliseconds(owen.period_ms), 1ms);
        DeviceRecord device;
        device.line = line;
        device.unit = owen.unit;
        device.flags = static_cast<std::uint8_t>(orders_of(owen) | DeviceRecord::kReadModifyWrite);
        device.attempts = owen.attempts;
        device.period = nanoseconds(std::chrono::milliseconds(owen.period_ms));
        device.response_timeout = nanoseconds(timeout);
        device.wait = nanoseconds(wire::response_wait(bus_.framing, bus_.format, timeout));
        device.round_trip = nanoseconds(1ms);  // of no meaning on a serial line
        device.backoff_first = device.backoff_limit = nanoseconds(pause);
        device.status = add_status(owen.status);
        device.poll_enable = local(owen.poll_enable);
        device.first_entry = entries_;
        for (std::uint32_t i = 0; i < owen.entry_count; ++i) {
            const std::uint32_t number = owen.first_entry + i;
            const auto entry = table_.entry(number);
            if (is_usable(entry) && !add_entry(index, owen, entry))
                return fail(Code::malformed, "entry"sv, std::int64_t{number});
        }
        device.entry_count = entries_ - device.first_entry;
        put(header_.devices, index, device);
        return {};
    }

    /// @returns false: it contradicts another entry
    bool add_entry(std::uint32_t device, const OwenDevice& owen, const OwenEntry& from) {
        const bool coils = wire::is_bit_area(area_of(from));
        const bool bit = from.kind() == OwenEntry::kBit;
        const std::uint32_t start = coils ? from.start * 16U + from.bit() : from.start;
        const std::uint32_t quantity = bit && !coils                           ? 1
                                       : from.kind() == OwenEntry::kDoubleWord ? from.quantity * 2U
                                                                               : from.quantity;
        if (start > 0xFFFF || quantity > 0xFFFF) return false;
        const bool polled = (from.flags & OwenEntry::kPolled) != 0;
        const auto flag = [](bool on, std::uint16_t value) { return on ? value : std::uint16_t{0}; };
        EntryRecord entry;
        entry.device = device;
        entry.read = from.read;
        entry.write = from.write;
        entry.flags = static_cast<std::uint16_t>(
            flag(polled, EntryRecord::kPolled) |
            flag((from.flags & OwenEntry::kWrittenOnChange) != 0, EntryRecord::kWrittenOnChange) |
            flag(bit && !coils && from.write != 0, EntryRecord::kReadModifyWrite));
        entry.start = static_cast<std::uint16_t>(start);
        entry.quantity = static_cast<std::uint16_t>(quantity);
        if (polled) entry.period = entry.deadline = nanoseconds(period_of(owen, from));
        entry.read_trigger = local(from.read_trigger);
        entry.write_trigger = local(from.write_trigger);
        entry.status = add_status(from.status);
        entry.first_member = members_;
        entry.member_count = from.quantity;
        for (std::uint32_t m = 0; m < from.quantity; ++m) {
            std::uint32_t item = from.data + m - 1U;
            put(header_.members, members_++, item);
            if (!add_member(item, device, owen, from, entry, m)) return false;
        }
        put(header_.entries, entries_++, entry);
        if (entry.read != 0 && entry.period > 0) add_load(entry);
        return true;
    }

    bool add_member(std::uint32_t index, std::uint32_t device, const OwenDevice& owen, const OwenEntry& from,
                    const EntryRecord& entry, std::uint32_t member) {
        const bool bit = from.kind() == OwenEntry::kBit;
        const bool coil = wire::is_bit_area(area_of(from));
        const bool two = from.kind() == OwenEntry::kDoubleWord;
        const auto type = static_cast<std::uint8_t>(bit   ? DataType::boolean
                                                    : two ? DataType::int32
                                                          : DataType::int16);
        const auto start =
            static_cast<std::uint16_t>(entry.start + (bit && !coil ? 0 : member * (two ? 2 : 1)));
        const std::int64_t period = nanoseconds(period_of(owen, from));
        auto record = item(index);
        if (record.device == kNone) {
            record.device = device;
            record.type = type;
            record.area = static_cast<std::uint8_t>(area_of(from));
            if (bit) record.bit = static_cast<std::uint8_t>(from.bit() + member);
            record.flags = static_cast<std::uint16_t>(ItemRecord::kUsed | orders_of(owen));
            record.start = start;
            record.registers = two ? 2 : 1;
            record.period = period;
            record.status = entry.status;
        }
        if (record.device != device || record.type != type || record.start != start) return false;
        if (from.read != 0) {
            record.read = from.read;
            record.read_trigger = entry.read_trigger;
            record.period = period;
        }
        if (from.write != 0) {
            record.write = from.write;
            record.write_trigger = entry.write_trigger;
            if ((entry.flags & EntryRecord::kWrittenOnChange) != 0)
                record.flags |= ItemRecord::kWrittenOnChange;
        }
        put(header_.items, index, record);
        return true;
    }

    /// The share of the line's time that a polled entry takes, without the response time of its device.
    void add_load(const EntryRecord& entry) {
        constexpr std::size_t kReadRequest = 5;  // of the PDU
        const Duration taken =
            2 * bus_.silence_before_request() + bus_.frame_time(kReadRequest) +
            bus_.frame_time(wire::response_pdu_length(wire::Function{entry.read}, entry.quantity));
        load_ += static_cast<std::uint64_t>(taken / 1us) * kWholeLoad /
                 static_cast<std::uint64_t>(Duration(entry.period) / 1us);
    }

    // A place that no entry uses belongs to the device of the place before it.
    void place_items() {
        std::uint32_t device = 0;
        for (std::uint32_t i = 0; i < header_.items.count; ++i) {
            auto record = item(i);
            if (i >= locals_ && record.device == kNone) {
                record.device = device;
                record.flags = 0;
            }
            if (i >= locals_) device = record.device;
            record.place = header_.value_words;
            header_.value_words += words_of(record);
            if (record.write != 0) {
                record.write_place = header_.write_words;
                header_.write_words += words_of(record);
            }
            put(header_.items, i, record);
        }
    }

    static constexpr std::uint64_t kWholeLoad = 1'000'000;

    const OwenView& table_;
    std::uint32_t locals_;
    std::span<std::uint8_t> into_;
    Header header_;
    bus::LineConfig bus_;
    std::uint64_t load_ = 0;  // of the line at hand
    std::uint32_t entries_ = 0, members_ = 0;
};

}  // namespace

std::size_t expanded_size(const OwenView& table) {
    return size_of(table, count(table));
}

Result<Bytes> expand(const OwenView& table, std::span<std::uint8_t> into) {
    const Counts counts = count(table);
    const std::uint64_t size = size_of(table, counts);
    if (size > kMaxImage)
        return fail(Code::overflow, static_cast<std::int64_t>(size), static_cast<std::int64_t>(kMaxImage));
    if (size > into.size())
        return fail(Code::too_short, static_cast<std::int64_t>(into.size()), static_cast<std::int64_t>(size));
    into = into.first(size);
    TAKT_CHECK(Expansion(table, counts, into).write());
    return Bytes(into);
}

}  // namespace takt::table
