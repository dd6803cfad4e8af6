#include "takt/console/keys.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "takt/base/utf8.hpp"

namespace takt::console {
namespace {

using Name = Key::Name;

constexpr char kEscape = '\x1b';
constexpr std::size_t kLongestSequence = 16;
constexpr std::size_t kLongestFilter = 64;  // bytes

struct Sequence {
    std::string_view bytes;
    Name name;
};

// As xterm and the Linux console send them; in application mode cursor keys begin with ESC O.
constexpr std::array kSequences{
    Sequence{"[A", Name::up},    Sequence{"[B", Name::down},     Sequence{"OA", Name::up},
    Sequence{"OB", Name::down},  Sequence{"[5~", Name::page_up}, Sequence{"[6~", Name::page_down},
    Sequence{"[H", Name::home},  Sequence{"[F", Name::end},      Sequence{"OH", Name::home},
    Sequence{"OF", Name::end},   Sequence{"[1~", Name::home},    Sequence{"[4~", Name::end},
    Sequence{"[7~", Name::home}, Sequence{"[8~", Name::end},
};

/// Bytes of the sequence behind ESC; 0: it is not complete.
std::size_t sequence_length(std::string_view text) {
    if (text.empty()) return 0;
    if (text[0] != '[') return text[0] == 'O' ? (text.size() > 1 ? 2 : 0) : 1;
    for (std::size_t i = 1; i < text.size(); ++i)
        if (text[i] >= '@' && text[i] <= '~') return i + 1;
    return 0;
}

/// Whether more bytes may make a character of it (RFC 3629).
bool is_cut_character(std::string_view text) {
    const auto lead = static_cast<unsigned char>(text.front());
    if (lead < 0xC2U || lead > 0xF4U) return false;
    const std::size_t bytes = lead < 0xE0U ? 2 : lead < 0xF0U ? 3 : 4;
    return text.size() < bytes && std::ranges::all_of(text.substr(1), continues_character);
}

Key key_of(char byte) {
    switch (byte) {
        case '\r':
        case '\n': return {.name = Name::enter};
        case '\b':
        case '\x7f': return {.name = Name::erase};
        default: return {.name = Name::character, .character = std::string(1, byte)};
    }
}

bool is_typed(const Key& key) {
    return key.name == Name::character && static_cast<unsigned char>(key.character.front()) >= ' ';
}

void erase_last(std::string& text) {
    while (!text.empty() && continues_character(text.back())) text.pop_back();
    if (!text.empty()) text.pop_back();
}

void type(report::LiveSelection& selection, const Key& key) {
    if (is_typed(key) && selection.filter.size() + key.character.size() <= kLongestFilter)
        selection.filter += key.character;
    if (key.name == Name::erase) erase_last(selection.filter);
    if (key.name == Name::escape) selection.filter.clear();
    if (key.name == Name::enter || key.name == Name::escape) selection.typing = false;
    selection.first = 0;
}

/// All, the first, the second, …, all.
void next_device(report::LiveSelection& selection, std::span<const std::string> devices) {
    const auto now = std::ranges::find(devices, selection.device);
    const auto next = selection.device.empty() || now == devices.end() ? devices.begin() : std::next(now);
    selection.device = next == devices.end() ? std::string() : *next;
    selection.first = 0;
}

/// The command of a key that moves the rows, as a letter.
char move_of(const Key& key) {
    switch (key.name) {
        case Name::up: return 'k';
        case Name::down: return 'j';
        case Name::page_up: return 'b';
        case Name::page_down: return ' ';
        case Name::home: return 'g';
        case Name::end: return 'G';
        case Name::character: return key.character.size() == 1 ? key.character.front() : '\0';
        default: return '\0';
    }
}

}  // namespace

void KeyReader::feed(std::string_view bytes, const std::function<void(const Key&)>& on_key) {
    const std::string text = std::exchange(rest_, {}) + std::string(bytes);
    for (std::string_view left = text; !left.empty();) {
        if (left.front() == kEscape) {
            const auto behind = left.substr(1);
            const auto length = sequence_length(behind);
            if (behind.empty() || behind.front() == kEscape) {
                on_key({.name = Name::escape});
                left.remove_prefix(1);
                continue;
            }
            if (length == 0) {
                if (left.size() < kLongestSequence) rest_ = left;
                return;
            }
            const auto* const known =
                std::ranges::find(kSequences, behind.substr(0, length), &Sequence::bytes);
            if (known != kSequences.end()) on_key({.name = known->name});
            left.remove_prefix(1 + length);
            continue;
        }
        const auto character = first_character(left);
        if (character.bytes > 1) {
            on_key({.name = Name::character, .character = std::string(left.substr(0, character.bytes))});
            left.remove_prefix(character.bytes);
        } else if (character.bytes == 1) {
            on_key(key_of(left.front()));
            left.remove_prefix(1);
        } else if (is_cut_character(left)) {
            rest_ = left;  // a character that is cut
            return;
        } else {
            left.remove_prefix(1);
        }
    }
}

bool apply_key(report::LiveSelection& selection, const Key& key, std::span<const std::string> devices) {
    if (selection.typing) {
        type(selection, key);
        return true;
    }
    const auto back = [&](std::size_t rows) { selection.first -= std::min(selection.first, rows); };
    const std::size_t page = std::max<std::size_t>(selection.page, 1);
    constexpr std::size_t kEnd = std::size_t{1} << 30;  // the display moves it to the last page
    switch (move_of(key)) {
        case 'q': return false;
        case 'k': back(1); break;
        case 'j': ++selection.first; break;
        case 'b': back(page); break;
        case ' ': selection.first += page; break;
        case 'g': selection.first = 0; break;
        case 'G': selection.first = kEnd; break;
        case '/':
            selection.typing = true;
            selection.filter.clear();
            break;
        case 'd': next_device(selection, devices); break;
        case '!':
            selection.not_good = !selection.not_good;
            selection.first = 0;
            break;
        default: break;
    }
    if (key.name == Name::escape) selection.filter.clear();
    return true;
}

}  // namespace takt::console
