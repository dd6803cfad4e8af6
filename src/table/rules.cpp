#include "rules.hpp"

#include <cmath>
#include <string_view>

#include "takt/wire/broadcast.hpp"
#include "takt/wire/frame.hpp"

namespace takt::table {

using namespace std::string_view_literals;
namespace {

using wire::Function;

// Longer than any time of a project, short enough that no sum of a few overflows.
constexpr std::int64_t kLongest = std::int64_t{400} * 24 * 3600 * 1'000'000'000;
constexpr std::uint16_t kLongestString = 125;

bool is_time(std::int64_t time) {
    return time >= 0 && time <= kLongest;
}

bool in_range(std::uint32_t first, std::uint32_t count, std::uint32_t whole) {
    return first <= whole && count <= whole - first;
}

bool reads(std::uint8_t function) {
    return wire::properties(Function{function}).only_reads_items();
}

bool writes(std::uint8_t function) {
    return wire::properties(Function{function}).only_writes_items();
}

constexpr auto kBoth = static_cast<std::uint8_t>(Function::read_write_multiple_registers);

bool carries(std::uint8_t function, std::uint32_t start, std::uint32_t quantity) {
    const auto most = wire::max_items(wire::Framing::tcp, Function{function});
    return quantity >= 1 && quantity <= most && start + quantity <= 0x10000;
}

bool functions_fit(const EntryRecord& entry) {
    if (entry.read == 0 && entry.write == 0) return false;
    if (entry.write == kBoth)
        return (entry.read == kBoth || entry.read == 0x03) && carries(kBoth, entry.start, entry.quantity) &&
               entry.write_quantity >= 1 && entry.write_quantity <= wire::kMaxReadWriteRegisters &&
               std::uint32_t{entry.write_start} + entry.write_quantity <= 0x10000;
    if (entry.read != 0 && !(reads(entry.read) && carries(entry.read, entry.start, entry.quantity)))
        return false;
    return entry.write == 0 || (writes(entry.write) && carries(entry.write, entry.start, entry.quantity));
}

}  // namespace

Result<void> Rules::check() const {
    const auto all = [this](std::string_view kind, std::uint32_t count, auto record) -> Result<void> {
        for (std::uint32_t i = 0; i < count; ++i)
            if (!holds(record(i), i)) return fail(Code::malformed, kind, i);
        return {};
    };
    const std::uint64_t most = std::uint64_t{view_.item_count()} * kLongestString;
    if (view_.header().value_words > most || view_.header().write_words > most)
        return fail(Code::malformed, "header"sv);
    TAKT_CHECK(all("item"sv, view_.item_count(), [this](auto i) { return view_.item(i); }));
    TAKT_CHECK(all("line"sv, view_.line_count(), [this](auto i) { return view_.line(i); }));
    TAKT_CHECK(all("device"sv, view_.device_count(), [this](auto i) { return view_.device(i); }));
    return all("entry"sv, view_.entry_count(), [this](auto i) { return view_.entry(i); });
}

bool Rules::is_text(std::uint32_t text) const {
    if (text == kNone) return true;
    if (texts_.size() < 2 || text > texts_.size() - 2) return false;
    std::uint16_t length = 0;
    Take{texts_.data() + text}(length);
    return length <= texts_.size() - 2 - text;
}

bool Rules::is_local_of(std::uint32_t index, bool boolean) const {
    if (index == kNone) return true;
    if (index >= view_.item_count()) return false;
    const auto item = view_.item(index);
    return item.device == kNone && (type_of(item) == DataType::boolean) == boolean;
}

// Locals come first, then the items of each device.
bool Rules::holds(const ItemRecord& item, std::uint32_t index) const {
    const bool local = item.device == kNone;
    if (!local && item.device >= view_.device_count()) return false;
    const auto before = index == 0 ? kNone : view_.item(index - 1).device;
    if (before != kNone && (local || item.device < before)) return false;
    if (item.type > static_cast<std::uint8_t>(DataType::string) || item.area > 3) return false;
    if (item.bit != ItemRecord::kNoBit && (item.bit > 15 || type_of(item) != DataType::boolean)) return false;
    if (item.registers < 1 || item.registers > kLongestString || words_of(item) != item.registers)
        return false;
    const bool coil = wire::is_bit_area(wire::Area{item.area});
    if (!local && coil && type_of(item) != DataType::boolean) return false;
    if (std::uint32_t{item.start} + items_of(item) > 0x10000) return false;
    if (item.read != 0 && (!reads(item.read) || wire::counts_bits(Function{item.read}) != coil)) return false;
    if (item.write != 0 && !(writes(item.write) || item.write == kBoth)) return false;
    if (!in_range(item.place, words_of(item), view_.header().value_words)) return false;
    if (item.write != 0 && item.write_place == kNone) return false;
    if (item.write_place != kNone && !in_range(item.write_place, words_of(item), view_.header().write_words))
        return false;
    if (!std::isfinite(item.scale) || item.scale == 0 || !std::isfinite(item.offset)) return false;
    if (!std::isfinite(item.dead_band) || item.dead_band < 0) return false;
    if (!is_text(item.default_text) || view_.text(item.default_text).size() > 2 * std::size_t{item.registers})
        return false;
    if (!is_time(item.period) || !is_time(item.greatest_age) || !is_time(item.min_interval) ||
        !is_local_of(item.read_trigger, true) || !is_local_of(item.write_trigger, true) ||
        !is_local_of(item.status, false))
        return false;
    return is_text(item.name) && is_text(item.unit);
}

bool Rules::holds(const LineRecord& line, std::uint32_t index) const {
    if (line.transport > 3 || line.framing > 2 || line.order > 1 || line.rs485 > 3 || line.parity > 2 ||
        line.echo > 2)
        return false;
    if (line.data_bits < 7 || line.data_bits > 8 || line.stop_bits < 1 || line.stop_bits > 2) return false;
    if (line.baud != 0 && (line.baud < 50 || line.baud > 10'000'000)) return false;
    if (line.in_flight < 1 || line.in_flight > 16 || line.command_burst < 1) return false;
    for (const auto time : {line.frame_gap, line.request_gap, line.margin, line.host_overhead,
                            line.broadcast_turnaround, line.frame_silence, line.cycle, line.command_interval})
        if (!is_time(time)) return false;
    // The parts of the lines are contiguous: each device and entry belongs to exactly one line.
    const auto before = index == 0 ? LineRecord{} : view_.line(index - 1);
    if (line.first_device != before.first_device + before.device_count ||
        line.first_entry != before.first_entry + before.entry_count)
        return false;
    if (!in_range(line.first_device, line.device_count, view_.device_count()) ||
        !in_range(line.first_entry, line.entry_count, view_.entry_count()))
        return false;
    const bool last = index + 1 == view_.line_count();
    if (last && (line.first_device + line.device_count != view_.device_count() ||
                 line.first_entry + line.entry_count != view_.entry_count()))
        return false;
    return is_text(line.name) && is_text(line.port);
}

bool Rules::holds(const DeviceRecord& device, std::uint32_t index) const {
    if (device.line >= view_.line_count() || device.attempts < 1 || device.gaps > 2) return false;
    if (device.in_flight < 1 || device.in_flight > 16) return false;
    const auto line = view_.line(device.line);
    if (index < line.first_device || index - line.first_device >= line.device_count) return false;
    for (const auto time : {device.period, device.response_timeout, device.wait, device.round_trip,
                            device.backoff_first, device.backoff_limit})
        if (!is_time(time)) return false;
    if (!is_time(device.measured_longest) || device.measured_exchanges < 0 || device.measured_in_flight < 1 ||
        device.measured_in_flight > 16)
        return false;
    if (device.turnaround != -1 && !is_time(device.turnaround)) return false;
    if (device.entry_count > 0 &&
        (device.first_entry < line.first_entry ||
         !in_range(device.first_entry - line.first_entry, device.entry_count, line.entry_count)))
        return false;
    return is_local_of(device.status, false) && is_local_of(device.poll_enable, true) && is_text(device.name);
}

bool Rules::holds(const EntryRecord& entry, std::uint32_t index) const {
    if (entry.device >= view_.device_count()) return false;
    const auto device = view_.device(entry.device);
    if (index < device.first_entry || index - device.first_entry >= device.entry_count) return false;
    if (!functions_fit(entry)) return false;
    const bool broadcast = UnitId{device.unit} == kBroadcast &&
                           view_.line(device.line).framing != static_cast<std::uint8_t>(wire::Framing::tcp);
    if (broadcast && (entry.read != 0 || !wire::may_be_broadcast(Function{entry.write}))) return false;
    const bool polled = (entry.flags & EntryRecord::kPolled) != 0;
    if (polled && entry.read == 0) return false;
    for (const auto time : {entry.period, entry.phase, entry.deadline, entry.min_interval, entry.bus_time})
        if (!is_time(time)) return false;
    if (polled && entry.phase != 0 && entry.phase >= entry.period) return false;
    if (!is_local_of(entry.read_trigger, true) || !is_local_of(entry.write_trigger, true) ||
        !is_local_of(entry.status, false))
        return false;
    if (entry.member_count < 1 ||
        !in_range(entry.first_member, entry.member_count, view_.header().members.count))
        return false;
    return members_hold(entry);
}

// Each member that is read overlaps the range of the read (a part of a long value may). Members that are
// written are contiguous and cover the range of the write; or they are bits of its only register.
bool Rules::members_hold(const EntryRecord& entry) const {
    const bool bits = wire::counts_bits(Function{entry.read != 0 ? entry.read : entry.write});
    const bool modifies = (entry.flags & EntryRecord::kReadModifyWrite) != 0;
    const bool of_register = modifies || Function{entry.write} == Function::mask_write_register;
    const bool whole = entry.write != 0 && entry.write != kBoth && !of_register;
    if (of_register && entry.quantity != 1) return false;
    if (modifies && (wire::counts_bits(Function{entry.write}) || !writes(entry.write))) return false;
    std::uint32_t next = entry.start;
    for (std::uint32_t i = 0; i < entry.member_count; ++i) {
        const auto index = view_.member(entry, i);
        if (index >= view_.item_count()) return false;
        const auto item = view_.item(index);
        if (item.device != entry.device || wire::is_bit_area(wire::Area{item.area}) != bits) return false;
        if ((whole || of_register) && item.write_place == kNone) return false;
        const bool touched = item.start < std::uint32_t{entry.start} + entry.quantity &&
                             item.start + items_of(item) > entry.start;
        if (entry.read != 0 && entry.read != kBoth && !touched) return false;
        if (whole && item.start != next) return false;
        if (of_register && (item.bit == ItemRecord::kNoBit || item.start != entry.start)) return false;
        next += items_of(item);
    }
    return !whole || next - entry.start == entry.quantity;
}

}  // namespace takt::table
