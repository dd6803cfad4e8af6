// Which items of a list come from which items of the file.
#pragma once

#include <cstddef>
#include <expected>
#include <optional>
#include <string_view>
#include <vector>

#include "takt/model/document.hpp"

namespace takt::file {

/// Of each wanted item the index of the old one; nothing: it is new.
using Origins = std::vector<std::optional<std::size_t>>;

/// Mappings are matched by kOriginKey. In lists without that key, equal items at both ends are matched, then
/// those between them by position.
/// @returns nothing if an index is out of range or used twice
[[nodiscard]] std::optional<Origins> match_items(const model::Node& old, const model::Node& wanted);

/// Whether the wanted items are the old ones in their order, none added or removed.
[[nodiscard]] bool keeps_order(const Origins& origins, std::size_t old_items);

/// The value of a key, first looked for at that index.
[[nodiscard]] const model::Node* find_near(const model::Node& mapping, std::string_view key,
                                           std::size_t index);

}  // namespace takt::file
