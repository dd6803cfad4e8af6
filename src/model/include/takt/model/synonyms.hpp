// Words of other tools for the keys of a project.
#pragma once

#include <string_view>

#include "takt/model/fields.hpp"

namespace takt::model {

/// The key of that object that a word of other tools means, in English, Russian or Ukrainian: `slave_id` is
/// the `address` of a device. ASCII letters in any case. Empty if none is known.
[[nodiscard]] std::string_view synonym(Object object, std::string_view word);

}  // namespace takt::model
