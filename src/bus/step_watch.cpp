#include "takt/bus/step_watch.hpp"

#include <algorithm>
#include <utility>

namespace takt::bus {

std::uint32_t frame_hash(Bytes pdu) {
    std::uint32_t hash = 0x811C9DC5U;
    for (const auto byte : pdu) hash = (hash ^ byte) * 0x01000193U;
    return hash;
}

void StepWatch::on_response(const Outcome& outcome) {
    const AnswerShape shape = answer_shape(outcome.request);
    if (outcome.sent_at >= quiet_at_) in_step_at_ = outcome.sent_at;
    if (shape != shape_ || outcome.request.repeated) in_step_at_ = outcome.ended_at;
    shape_ = shape;
    hash_ = frame_hash(outcome.response.pdu());
    quiet_at_ = outcome.quiet_at;
    pause_ = quiet_at_ - outcome.ended_at;
}

// More of them may follow. What was read before has been named.
std::optional<Instant> StepWatch::on_surplus(const SurplusFrame& frame) {
    const Instant since = std::exchange(in_step_at_, frame.at);
    quiet_at_ = std::max(quiet_at_, frame.at + pause_);
    alert_until_ = frame.at + kAlert;
    if (frame.shape == shape_ && frame.hash == hash_) return std::nullopt;
    return since;
}

Instant StepWatch::earliest(Instant t, const AnswerShape& shape, Duration interval) const {
    if (shape != shape_ || t >= quiet_at_) return t;
    const bool due = t - in_step_at_ >= (t < alert_until_ ? kAlertInterval : interval);
    return due ? quiet_at_ : t;
}

}  // namespace takt::bus
