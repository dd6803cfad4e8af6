// The keys of a live display: bytes of a terminal to keys, keys to what is shown.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "takt/report/states/live_screen.hpp"

namespace takt::console {

/// A key: one of the names, or a character.
struct Key {
    enum class Name : std::uint8_t {
        character,
        up,
        down,
        page_up,
        page_down,
        home,
        end,
        enter,
        escape,
        erase
    };
    Name name = Name::character;
    std::string character = {};  ///< of Name::character: one, in UTF-8
    friend bool operator==(const Key&, const Key&) = default;
};

/// Splits what a terminal sends into keys (ECMA-48 sequences, UTF-8). A sequence may be cut anywhere, but a
/// lone ESC at the end of what was read is the key Esc.
class KeyReader {
public:
    void feed(std::string_view bytes, const std::function<void(const Key&)>& on_key);

private:
    std::string rest_;  // the beginning of a sequence or character
};

/// Changes what is shown. Unknown keys do nothing.
/// @param devices  in the order in which `d` goes through them
/// @returns false: the key asks for the end
[[nodiscard]] bool apply_key(report::LiveSelection& selection, const Key& key,
                             std::span<const std::string> devices);

}  // namespace takt::console
