#include "request_queue.hpp"

#include <algorithm>

#include "takt/wire/function.hpp"

namespace takt::capture {

std::uint32_t items_of(Bytes pdu) {
    const auto word = [&](std::size_t at) -> std::uint32_t {
        return pdu.size() >= at + 2 ? std::uint32_t{pdu[at]} << 8U | pdu[at + 1] : 0U;
    };
    const auto& row = wire::properties(wire::Function{pdu[0]});
    const bool has_value = row.writes_single() || row.request == wire::RequestForm::masks;
    return word(1) << 16U | (has_value ? 0U : word(3));
}

bool RequestQueue::push(const Waiting& request) {
    const bool repeated = std::ranges::any_of(waiting_, [&](const Waiting& waiting) {
        return waiting.transaction == request.transaction && waiting.unit == request.unit &&
               waiting.function == request.function;
    });
    waiting_.push_back(request);
    return repeated;
}

std::optional<RequestQueue::Waiting> RequestQueue::take(std::uint16_t transaction, std::uint8_t unit,
                                                        std::uint8_t function) {
    const auto found = std::ranges::find_if(waiting_, [&](const Waiting& waiting) {
        return waiting.transaction == transaction && waiting.unit == unit && waiting.function == function;
    });
    if (found == waiting_.end()) return std::nullopt;
    const auto taken = *found;
    waiting_.erase(found);
    return taken;
}

std::optional<RequestQueue::Waiting> RequestQueue::take_expired(std::int64_t now_ns, Duration forget) {
    if (waiting_.empty()) return std::nullopt;
    const bool old = now_ns - waiting_.front().packet.time_ns > forget.count();
    if (!old && waiting_.size() < kMost) return std::nullopt;
    return take_oldest();
}

std::optional<RequestQueue::Waiting> RequestQueue::take_oldest() {
    if (waiting_.empty()) return std::nullopt;
    const auto taken = waiting_.front();
    waiting_.pop_front();
    return taken;
}

}  // namespace takt::capture
