// The words of one item: as in the registers of its device, as in the value buffer.
#pragma once

#include <cstdint>
#include <span>

#include "takt/table/view.hpp"
#include "takt/wire/pdu.hpp"
#include "takt/wire/response_view.hpp"

namespace takt::table {

/// Takes what of an item is among the registers from `start` on; the other words stay. words.size() is
/// words_of(item).
void words_from(const ItemRecord& item, std::uint16_t start, wire::RegisterView registers,
                std::span<std::uint16_t> words);

/// Appends the registers of a number or a string; there must be room.
void registers_of(const ItemRecord& item, std::span<const std::uint16_t> words, wire::Registers& registers);

/// The default, zeros where there is none.
void default_words(const View& view, const ItemRecord& item, std::span<std::uint16_t> words);

}  // namespace takt::table
