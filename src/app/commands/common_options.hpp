// The options that every command has.
#pragma once

#include <string>

#include "takt/text/language.hpp"

namespace takt::app {

struct CommonOptions {
    text::Language language = text::Language::english;
    std::string log_file;
    std::string log_level = "info";
};

}  // namespace takt::app
