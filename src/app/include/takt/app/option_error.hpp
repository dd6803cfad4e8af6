// What is wrong with the options of a command, in the user's language.
#pragma once

#include <string>
#include <string_view>

#include "takt/app/texts.hpp"

namespace takt::app {

/// @param kind  the command line library's name of the error: RequiredError, ExtrasError, …
/// @param what  its English words, from which names, values and limits are taken. Words it does not know are
/// given back as they are.
[[nodiscard]] std::string option_error(const Texts& texts, std::string_view kind, std::string_view what);

}  // namespace takt::app
