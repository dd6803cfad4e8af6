// The words of --help. Commands and options are described by codes (`help.…`); here they become texts.
#pragma once

#include <CLI/CLI.hpp>

#include "takt/app/texts.hpp"

namespace takt::app {

/// Puts the texts of a language in the place of the codes, of all commands below `app` too.
void put_into_words(CLI::App& app, const Texts& texts);

}  // namespace takt::app
