// A board for the tests: hand-moved time, a UART that takes as long as its bit rate, flash that the power may
// leave at any word.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "takt/firmware/board.hpp"

namespace takt::firmware::model {

/// Thrown by the flash when the power fails.
struct PowerFailure {};

struct Board {
    static constexpr std::size_t kPageWords = 32;

    BoardEvents* events = nullptr;
    std::uint32_t now = 0;  // microseconds
    std::optional<std::uint32_t> timer_at;
    std::uint32_t character_time = 0;
    std::optional<std::uint32_t> sent_at;  // the character on the line ends
    std::string log;                       // '+' driver on, '-' off, 's' sent: in their order
    std::vector<std::uint8_t> sent;
    std::array<std::vector<std::uint32_t>, 4> flash = [] {
        const std::vector<std::uint32_t> erased(kPageWords, ~0U);
        return std::array{erased, erased, erased, erased};
    }();
    /// Words and erasures until the power fails in one of them; nothing: never.
    std::optional<std::size_t> fails_after;
    std::uint32_t torn = 0;  ///< the bits of that word that stay as they were

    /// Moves the time and calls the events that are due, in their order.
    void pass(std::uint32_t microseconds);
    /// A character whose stop bit ends now.
    void receive(std::uint8_t character, bool damaged = false) { events->on_character(character, damaged); }
};

/// The board of board.hpp. A test starts with a new one.
extern Board board;

}  // namespace takt::firmware::model
