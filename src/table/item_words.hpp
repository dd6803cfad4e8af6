// The words of one item: as in the registers of its device, as in the value buffer.
#pragma once

#include <cstdint>
#include <span>

#include "takt/table/view.hpp"
#include "takt/wire/pdu.hpp"
#include "takt/wire/response_view.hpp"

namespace takt::table {

/// Copies the registers of an item that are among those read from `start` on; other words are unchanged.
/// words.size() is words_of(item).
void words_from(const ItemRecord& item, std::uint16_t start, wire::RegisterView registers,
                std::span<std::uint16_t> words);

/// Appends the registers of a number or a string; they must fit.
void registers_of(const ItemRecord& item, std::span<const std::uint16_t> words, wire::Registers& registers);

/// Of a bool in a register: its bit as on the wire.
std::uint16_t bit_mask(const ItemRecord& item);

/// The default of an item, or zeros.
void default_words(const View& view, const ItemRecord& item, std::span<std::uint16_t> words);

}  // namespace takt::table
