#include "network/request_queue.hpp"

#include <algorithm>

#include "files/big_endian.hpp"
#include "takt/wire/function.hpp"

namespace takt::capture {
namespace {

// A client has given up a request if it sends an equal one after this multiple of the usual response time,
// but not before kLeastPause.
constexpr std::int64_t kPauseFactor = 10;
constexpr std::int64_t kLeastPause = 20'000'000;     // ns
constexpr std::int64_t kMostUsual = 60'000'000'000;  // ns; a longer response time is no usual one
constexpr std::int64_t kSmoothing = 8;               // as the round-trip time of RFC 6298

std::uint32_t word(Bytes pdu, std::size_t at) {
    return pdu.size() >= at + 2 ? be16_at(pdu, at) : 0U;
}

bool is_equal(const RequestQueue::Waiting& a, std::uint16_t transaction, std::uint8_t unit,
              std::uint8_t function) {
    return a.transaction == transaction && a.unit == unit && a.function == function;
}

/// Whether the response has the size or the address that the request asks for, as far as `items` decides it.
bool fits(const RequestQueue::Waiting& request, Bytes response) {
    if (response[0] != request.function || response.size() < 3) return true;
    const auto& row = wire::properties(wire::Function{request.function});
    const std::uint32_t quantity = request.items & 0xFFFFU;
    switch (row.response) {
        case wire::ResponseForm::items:
            return response[1] == (row.counts_bits() ? (quantity + 7) / 8 : 2 * quantity);
        case wire::ResponseForm::head: return word(response, 1) == request.items >> 16U;
        case wire::ResponseForm::repeated:
            return !row.writes_single() || word(response, 1) == request.items >> 16U;
        default: return true;
    }
}

}  // namespace

std::uint32_t items_of(Bytes pdu) {
    const auto& row = wire::properties(wire::Function{pdu[0]});
    const bool has_value = row.writes_single() || row.request == wire::RequestForm::masks;
    return word(pdu, 1) << 16U | (has_value ? 0U : word(pdu, 3));
}

bool RequestQueue::push(const Waiting& request) {
    const bool repeated = std::ranges::any_of(waiting_, [&](const Waiting& waiting) {
        return is_equal(waiting, request.transaction, request.unit, request.function);
    });
    waiting_.push_back(request);
    return repeated;
}

bool RequestQueue::supersedes(const Waiting& later, const Waiting& earlier, Bytes response) const {
    if (!fits(later, response)) return false;
    const auto pause = later.packet.time_ns - earlier.packet.time_ns;
    return !fits(earlier, response) || pause > std::max(kPauseFactor * usual_ns_, kLeastPause);
}

std::optional<RequestQueue::Waiting> RequestQueue::take(const Adu& response) {
    const auto function = wire::requested_function(response.pdu[0]);
    auto found = waiting_.end();
    std::size_t equal = 0;
    for (auto each = waiting_.begin(); each != waiting_.end(); ++each) {
        if (!is_equal(*each, response.transaction, response.unit, function)) continue;
        if (++equal == 1 || supersedes(*each, *found, response.pdu)) found = each;
    }
    if (equal == 0) return std::nullopt;
    const auto taken = *found;
    waiting_.erase(found);
    // Of several equal ones it is not certain which one was answered.
    if (equal == 1) learn(response.packet.time_ns - taken.packet.time_ns);
    return taken;
}

// A capture whose packets are not in the order of time has negative response times.
void RequestQueue::learn(std::int64_t response_ns) {
    response_ns = std::clamp<std::int64_t>(response_ns, 0, kMostUsual);
    usual_ns_ += usual_ns_ == 0 ? response_ns : (response_ns - usual_ns_) / kSmoothing;
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
