// Converts between the words of the value buffer and the registers of a device.
#include "item_words.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"
#include "takt/table/executor.hpp"

namespace takt::table {
namespace {

constexpr std::uint16_t swapped(std::uint16_t word) {
    return static_cast<std::uint16_t>(word << 8 | word >> 8);
}

bool reversed(const ItemRecord& item) {
    return type_of(item) != DataType::string && (item.flags & ItemRecord::kHighRegisterFirst) != 0;
}

std::uint16_t in_order(const ItemRecord& item, std::uint16_t word) {
    return (item.flags & ItemRecord::kHighByteFirst) != 0 ? word : swapped(word);
}

}  // namespace

std::uint16_t bit_mask(const ItemRecord& item) {
    return in_order(item, static_cast<std::uint16_t>(1U << item.bit));
}

void words_from(const ItemRecord& item, std::uint16_t start, wire::RegisterView registers,
                std::span<std::uint16_t> words) {
    for (std::size_t i = 0; i < words.size(); ++i) {
        const auto at = static_cast<std::ptrdiff_t>(item.start + i) - start;
        if (at < 0 || at >= static_cast<std::ptrdiff_t>(registers.size())) continue;
        const auto word = in_order(item, registers[static_cast<std::size_t>(at)]);
        if (type_of(item) == DataType::boolean)
            words[i] = item.bit == ItemRecord::kNoBit ? word != 0 : (word >> item.bit & 1);
        else
            words[reversed(item) ? words.size() - 1 - i : i] = word;
    }
}

void registers_of(const ItemRecord& item, std::span<const std::uint16_t> words, wire::Registers& registers) {
    for (std::size_t i = 0; i < words.size(); ++i)
        registers.push_back(in_order(item, words[reversed(item) ? words.size() - 1 - i : i]));
}

void default_words(const View& view, const ItemRecord& item, std::span<std::uint16_t> words) {
    if (type_of(item) != DataType::string) {
        for (std::size_t i = 0; i < words.size(); ++i)
            words[i] = static_cast<std::uint16_t>(item.default_raw >> (16 * i));
        return;
    }
    const auto text = view.text(item.default_text);
    std::fill(words.begin(), words.end(), std::uint16_t{0});
    for (std::size_t i = 0; i < text.size(); ++i)
        words[i / 2] = static_cast<std::uint16_t>(words[i / 2] | static_cast<std::uint8_t>(text[i])
                                                                     << (i % 2 == 0 ? 8 : 0));
}

// The value last set, else last read, else the default (initialise() puts it where it is read); empty: none.
std::span<const std::uint16_t> Executor::value_to_write(const ItemRecord& item, std::uint32_t index) const {
    const auto& state = memory_.items[index];
    if (state.wanted) return memory_.wanted.subspan(item.write_place, words_of(item));
    if (state.read) return memory_.read.subspan(item.write_place, words_of(item));
    return {};
}

bool Executor::group_ready(const EntryState& state, const EntryRecord& entry) const {
    if (writes_bits(entry)) return any_chosen(state, entry);
    for (std::uint32_t m = 0; m < entry.member_count; ++m) {
        const auto index = view_.member(entry, m);
        if (value_to_write(view_.item(index), index).empty()) return false;
    }
    return true;
}

Result<wire::PreparedRequest> Executor::write_request(const EntryRecord& entry) const {
    using wire::Function;
    if (writes_bits(entry)) return bits_request(entry);
    const auto function = Function{entry.write};
    const bool coils = wire::counts_bits(function);
    wire::Bits bits;
    wire::Registers registers;
    for (std::uint32_t m = 0; m < entry.member_count; ++m) {
        const auto index = view_.member(entry, m);
        const auto item = view_.item(index);
        const auto words = value_to_write(item, index);
        if (!coils && type_of(item) == DataType::boolean) return fail(Code::unsupported);
        if (coils)
            bits.push_back(words[0] != 0);
        else
            registers_of(item, words, registers);
    }
    return wire::prepare_write(function, DataAddress{entry.start}, bits, registers);
}

Result<void> Executor::set(std::uint32_t index, std::span<const std::uint16_t> words) {
    if (index >= view_.item_count()) return fail(Code::not_writable, std::int64_t{index});
    const auto item = view_.item(index);
    const bool own = item.device != kNone && item.device >= line_.first_device &&
                     item.device - line_.first_device < line_.device_count;
    if (!own || item.write == 0 || (item.flags & ItemRecord::kUsed) == 0 || words.size() != words_of(item))
        return fail(Code::not_writable, std::int64_t{index});
    std::copy(words.begin(), words.end(), memory_.wanted.begin() + item.write_place);
    auto& state = memory_.items[index];
    state.wanted = true;
    // If several entries write it on change, the last one does, as in the poller.
    for (std::uint32_t e = static_cast<std::uint32_t>(entries_.size()); e-- > 0;) {
        const auto record = entry(e);
        if ((record.flags & EntryRecord::kWrittenOnChange) == 0 || record.write == 0) continue;
        for (std::uint32_t m = 0; m < record.member_count; ++m) {
            if (view_.member(record, m) != index) continue;
            ask(e);
            state.pending = entries_[e].asked = true;
            return {};
        }
    }
    return {};
}

void Executor::ask(std::uint32_t index) {
    auto& state = entries_[index];
    if (!state.asked && !state.write_triggered) state.write_order = ++last_order_;
}

}  // namespace takt::table
