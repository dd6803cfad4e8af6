// The compiled catalogues: made by tools/po2cpp, read by catalogue.cpp.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "takt/text/catalogue.hpp"

namespace takt::text {

struct Entry {
    std::string_view code;
    std::array<std::string_view, kLanguages.size()> texts;  // in the order of Language; empty: not translated
};

/// Sorted by code, bytewise.
std::span<const Entry> entries();

}  // namespace takt::text
