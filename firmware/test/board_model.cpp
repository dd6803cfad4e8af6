#include "board_model.hpp"

#include <algorithm>

namespace takt::firmware {

model::Board model::board;

void model::Board::pass(std::uint32_t microseconds) {
    const std::uint32_t end = now + microseconds;
    for (;;) {
        const auto left = [&](const std::optional<std::uint32_t>& at) { return at ? *at - now : ~0U; };
        const std::uint32_t next = std::min(left(timer_at), left(sent_at));
        if (next > end - now) break;
        now += next;
        if (timer_at == now) {
            timer_at.reset();
            events->on_timer();
        } else {
            sent_at.reset();
            events->on_sent();
        }
    }
    now = end;
}

namespace board {

using model::board;

std::uint32_t clock() {
    return board.now;
}

bool open(const wire::CharacterFormat& format, BoardEvents& events, unsigned) {
    if (format.stop_bits != 1) return false;
    board.events = &events;
    board.character_time =
        static_cast<std::uint32_t>(wire::transmission_time(format, 1) / std::chrono::microseconds(1));
    return true;
}

void send(std::uint8_t character, unsigned) {
    board.sent.push_back(character);
    board.log += 's';
    board.sent_at = board.now + board.character_time;
}

void start_timer(std::uint32_t microseconds, unsigned) {
    board.timer_at = board.now + microseconds;
}

void stop_timer(unsigned) {
    board.timer_at.reset();
}

void drive_line(bool on, unsigned) {
    board.log += on ? '+' : '-';
}

std::span<const std::uint32_t> flash_page(unsigned page) {
    return board.flash[page];
}

namespace {

bool fails() {
    if (!board.fails_after) return false;
    if (*board.fails_after > 0) {
        --*board.fails_after;
        return false;
    }
    board.fails_after.reset();
    return true;
}

}  // namespace

void erase_page(unsigned page) {
    const bool failing = fails();
    for (auto& word : board.flash[page]) word = failing ? word | ~board.torn : ~0U;
    if (failing) throw model::PowerFailure{};
}

void write_word(unsigned page, std::size_t index, std::uint32_t word) {
    const bool failing = fails();
    board.flash[page].at(index) &= failing ? word | board.torn : word;
    if (failing) throw model::PowerFailure{};
}

void sleep() {}

}  // namespace board
}  // namespace takt::firmware
