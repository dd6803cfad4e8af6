// Case of HTTP names.
#pragma once

#include <string>
#include <string_view>

namespace takt::web {

/// `text` with A to Z in lower case; other bytes stay.
[[nodiscard]] inline std::string lower_ascii(std::string_view text) {
    std::string result(text);
    for (auto& c : result)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + ('a' - 'A'));
    return result;
}

}  // namespace takt::web
