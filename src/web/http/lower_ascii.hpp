// Case of HTTP names.
#pragma once

#include <string>
#include <string_view>

#include "takt/base/ascii.hpp"

namespace takt::web {

/// `text` with A to Z in lower case; other bytes stay.
[[nodiscard]] inline std::string lower_ascii(std::string_view text) {
    std::string result(text);
    for (auto& c : result) c = lower_case(c);
    return result;
}

}  // namespace takt::web
