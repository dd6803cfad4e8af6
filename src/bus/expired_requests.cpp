#include "takt/bus/expired_requests.hpp"

#include <algorithm>

#include "takt/wire/function.hpp"

namespace takt::bus {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kLongestTimeout{65535};

bool has_shape(const AnswerShape& expected, Bytes pdu) {
    if (expected.function != wire::requested_function(pdu[0])) return false;
    return wire::is_exception(pdu[0]) || expected.pdu_length == 0 || expected.pdu_length == pdu.size();
}

}  // namespace

Duration advised_timeout(Duration delay) {
    constexpr std::int64_t kTenths[] = {10, 15, 20, 30, 40, 50, 60, 80, 100};
    const auto least = std::max<std::int64_t>(std::chrono::ceil<milliseconds>(delay + delay / 5).count(), 1);
    for (std::int64_t decade = 1; decade <= kLongestTimeout.count(); decade *= 10)
        for (const auto tenths : kTenths)
            if (tenths * decade >= 10 * least && (tenths * decade) % 10 == 0)
                return std::min(kLongestTimeout, milliseconds(tenths * decade / 10));
    return kLongestTimeout;
}

void ExpiredRequests::add(const Request& request) {
    if (requests_.full()) requests_.drop_front(1);
    requests_.push_back({request, std::nullopt});
}

bool ExpiredRequests::expects(std::uint16_t wire_id) const {
    return std::any_of(requests_.begin(), requests_.end(),
                       [&](const Entry& entry) { return !entry.late && entry.request.wire_id == wire_id; });
}

bool ExpiredRequests::settle(UnitId unit, Bytes pdu, std::optional<std::uint16_t> wire_id, Instant begin,
                             Instant end) {
    if (pdu.empty()) return false;
    const auto is_answered = [&](const Entry& entry) {
        const auto& request = entry.request;
        if (entry.late || request.unit != unit || end - request.expired_at > kRemembered) return false;
        return wire_id
                   ? request.wire_id == *wire_id && request.shape.function == wire::requested_function(pdu[0])
                   : has_shape(request.shape, pdu);
    };
    auto* const found = std::find_if(requests_.begin(), requests_.end(), is_answered);
    if (found == requests_.end()) return false;
    found->late = LateResponse{.unit = unit,
                               .function = found->request.shape.function,
                               .at = end,
                               .delay = std::max(begin - found->request.end, Duration::zero()),
                               .wait = found->request.wait};
    for (auto& entry : requests_)
        if (entry.request.unit == unit) entry.request.end = std::max(entry.request.end, end);
    return true;
}

void ExpiredRequests::note_response(UnitId unit, const AnswerShape& shape, Instant request_end,
                                    Duration wait) {
    auto* const found = std::find_if(requests_.begin(), requests_.end(), [&](const Entry& entry) {
        return !entry.late && entry.request.unit == unit && entry.request.shape == shape;
    });
    if (found == requests_.end()) return;
    found->request.end = request_end;
    found->request.wait = wait;
}

std::optional<LateResponse> ExpiredRequests::take() {
    auto* const found =
        std::find_if(requests_.begin(), requests_.end(), [](const Entry& entry) { return entry.late; });
    if (found == requests_.end()) return std::nullopt;
    const auto late = found->late;
    std::copy(found + 1, requests_.end(), found);
    requests_.pop_back();
    return late;
}

}  // namespace takt::bus
