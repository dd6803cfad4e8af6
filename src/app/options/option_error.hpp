// What is wrong with the options of a command, in the user's language.
#pragma once

#include <string>
#include <string_view>

#include "texts.hpp"

namespace takt::app {

/// @param what  the English words of the command line library, from which names, values and limits are taken.
/// Words that are not known are given back as they are.
[[nodiscard]] std::string option_error(const Texts& texts, std::string_view what);

}  // namespace takt::app
