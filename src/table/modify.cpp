// Bits of registers: which of an entry are written, by 0x16 or by read-modify-write.
#include "item_words.hpp"
#include "shapes.hpp"
#include "takt/base/assert.hpp"
#include "takt/table/executor.hpp"

namespace takt::table {

bool Executor::writes_bits(const EntryRecord& entry) {
    return modifies(entry) || wire::Function{entry.write} == wire::Function::mask_write_register;
}

bool Executor::any_wanted(const EntryRecord& entry) const {
    for (std::uint32_t m = 0; m < entry.member_count; ++m)
        if (memory_.items[view_.member(entry, m)].wanted) return true;
    return false;
}

// By a change: the bits set since the last write. By a trigger: all bits ever set; if there are none, the
// bits as read, else with their defaults. Other bits are not written back: that would undo changes made
// elsewhere.
bool Executor::is_chosen(const EntryState& state, const EntryRecord& entry, std::uint32_t item) const {
    const auto& known = memory_.items[item];
    if (!state.write_triggered) return known.pending;
    return known.wanted || (known.read && !any_wanted(entry));
}

bool Executor::any_chosen(const EntryState& state, const EntryRecord& entry) const {
    for (std::uint32_t m = 0; m < entry.member_count; ++m)
        if (is_chosen(state, entry, view_.member(entry, m))) return true;
    return false;
}

void Executor::choose_bits(const EntryState& state, const EntryRecord& entry) {
    for (std::uint32_t m = 0; m < entry.member_count; ++m) {
        const auto index = view_.member(entry, m);
        auto& item = memory_.items[index];
        item.sending = is_chosen(state, entry, index);
        if (item.sending) item.pending = false;
    }
}

Result<wire::PreparedRequest> Executor::first_request(const EntryRecord& entry) const {
    if (!modifies(entry)) return write_request(entry);
    TAKT_TRY(const auto read, wire::prepare(read_before(entry)));
    return read;
}

// Result = (current AND and_mask) OR (or_mask AND NOT and_mask): MODBUS Application Protocol V1.1b3,
// section 6.16.
Result<wire::PreparedRequest> Executor::bits_request(const EntryRecord& entry) const {
    std::uint16_t mask = 0;
    std::uint16_t bits = 0;
    for (std::uint32_t m = 0; m < entry.member_count; ++m) {
        const auto index = view_.member(entry, m);
        const auto item = view_.item(index);
        if (!memory_.items[index].sending) continue;
        const std::uint16_t bit = bit_mask(item);
        mask |= bit;
        if (value_to_write(item, index)[0] != 0) bits |= bit;
    }
    const DataAddress address{entry.start};
    if (!modifies(entry))
        return wire::prepare(
            wire::MaskWriteRegisterRequest{address, static_cast<std::uint16_t>(~mask), bits});
    wire::Registers registers;
    registers.push_back(static_cast<std::uint16_t>((modify_.old & ~mask) | bits));
    return wire::prepare_write(wire::Function{entry.write}, address, {}, registers);
}

// @returns whether the write follows; else nothing was written
bool Executor::take_register(const bus::Outcome& outcome, bool ok) {
    modify_.step = ok ? Modify::Step::writing : Modify::Step::none;
    if (ok) modify_.old = outcome.response.registers()[0];
    return ok;
}

}  // namespace takt::table
