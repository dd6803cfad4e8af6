// The lengths of the PDUs of reads and writes, and how many items fit into a request.
#include <algorithm>

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

std::size_t request_pdu_length(Function function, std::size_t quantity, std::size_t written) {
    const auto& row = properties(function);
    if (row.most_items == 0) return 0;
    if (row.request == RequestForm::exchange) return row.request_bytes + 2 * written;
    return row.request_bytes + (row.counts_request() ? data_bytes(function, quantity) : 0);
}

std::size_t response_pdu_length(Function function, std::size_t quantity) {
    const auto& row = properties(function);
    if (row.most_items == 0) return 0;
    return row.response_bytes + (row.returns_items() ? data_bytes(function, quantity) : 0);
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
    std::size_t greatest = properties(function).most_items;
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
