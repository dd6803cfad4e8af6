// Words of other tools for the keys of a project and their values.
#pragma once

#include <span>
#include <string_view>

#include "takt/model/fields.hpp"

namespace takt::model {

/// The key of that object that a word of other tools means, in English, Russian or Ukrainian: `slave_id` is
/// the `address` of a device. ASCII letters in any case; a longer word may have one typing mistake. Empty if
/// none is known.
[[nodiscard]] std::string_view synonym(Object object, std::string_view word);

/// The key of `other` that a word means in any object: `connect` in a device is the `host` of its line. Empty
/// if the word is none of these.
[[nodiscard]] std::string_view synonym_elsewhere(Object other, std::string_view word);

/// The word of `words` that a value of other tools means for `key`: `E` is the `even` of `parity`, `dword`
/// the `uint32` of `type`. ASCII letters in any case. Empty if none is known.
[[nodiscard]] std::string_view value_synonym(std::string_view key, std::span<const std::string_view> words,
                                             std::string_view value);

/// The word of `words` that a value means: its value_synonym(), else the nearest() one that is not
/// is_unlike(). Empty if none is near.
[[nodiscard]] std::string_view meant_word(std::string_view key, std::span<const std::string_view> words,
                                          std::string_view value);

}  // namespace takt::model
