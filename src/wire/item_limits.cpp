// The lengths of the PDUs of reads and writes, and how many items fit into a request.
#include <algorithm>

#include "item_limits.hpp"
#include "takt/wire/frame.hpp"

namespace takt::wire {
namespace {

std::size_t data_bytes(Function function, std::size_t quantity) {
    return counts_bits(function) ? (quantity + 7) / 8 : 2 * quantity;
}

std::size_t buffer_of(Framing framing, const FrameLimits& limits) {
    const std::size_t own = frame_length(framing, kMaxPdu);
    return limits.frame_buffer == 0 ? own : std::min(limits.frame_buffer, own);
}

}  // namespace

std::size_t most_items(Function function) {
    switch (function) {
        case Function::read_coils:
        case Function::read_discrete_inputs: return kMaxReadBits;
        case Function::read_holding_registers:
        case Function::read_input_registers:
        case Function::read_write_multiple_registers: return kMaxReadRegisters;
        case Function::write_multiple_coils: return kMaxWriteBits;
        case Function::write_multiple_registers: return kMaxWriteRegisters;
        case Function::write_single_coil:
        case Function::write_single_register:
        case Function::mask_write_register: return 1;
        default: return 0;
    }
}

std::size_t request_pdu_length(Function function, std::size_t quantity, std::size_t written) {
    switch (function) {
        case Function::write_multiple_coils:
        case Function::write_multiple_registers: return 6 + data_bytes(function, quantity);
        case Function::mask_write_register: return 7;
        case Function::read_write_multiple_registers: return 10 + 2 * written;
        default: return most_items(function) == 0 ? 0 : 5;
    }
}

std::size_t response_pdu_length(Function function, std::size_t quantity) {
    switch (function) {
        case Function::read_coils:
        case Function::read_discrete_inputs:
        case Function::read_holding_registers:
        case Function::read_input_registers:
        case Function::read_write_multiple_registers: return 2 + data_bytes(function, quantity);
        case Function::mask_write_register: return 7;
        default: return most_items(function) == 0 ? 0 : 5;
    }
}

std::size_t max_items(Framing framing, Function function, const FrameLimits& limits) {
    const std::size_t buffer = buffer_of(framing, limits);
    const auto fits = [&](std::size_t quantity) {
        const std::size_t longer =
            std::max(request_pdu_length(function, quantity, 1), response_pdu_length(function, quantity));
        return longer <= kMaxPdu && frame_length(framing, longer) <= buffer;
    };
    // The lengths grow with the quantity: bisection finds the greatest quantity that fits.
    std::size_t least = 0;
    std::size_t greatest = most_items(function);
    if (limits.max_items != 0) greatest = std::min(greatest, limits.max_items);
    while (least < greatest) {
        const std::size_t middle = (least + greatest + 1) / 2;
        if (fits(middle)) {
            least = middle;
        } else {
            greatest = middle - 1;
        }
    }
    return least;
}

}  // namespace takt::wire
