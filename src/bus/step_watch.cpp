#include "takt/bus/step_watch.hpp"

#include <algorithm>
#include <utility>

namespace takt::bus {

std::uint32_t frame_hash(Bytes pdu) {
    std::uint32_t hash = 0x811C9DC5U;
    for (const auto byte : pdu) hash = (hash ^ byte) * 0x01000193U;
    return hash;
}

// An exception does not show the shape of its request. A response of another shape shows that those before it
// were the own ones; it may itself be a copy of the past, so it is not named as one that is in step.
void StepWatch::on_outcome(const Outcome& outcome) {
    const bool came = outcome.status == Status::ok || outcome.status == Status::exception ||
                      outcome.status == Status::ambiguous;
    if (!came || outcome.unit == kBroadcast) return;
    if (outcome.sent_at >= quiet_at_) {
        in_step_at_ = outcome.sent_at;
        drained_ = true;
    }
    quiet_at_ = std::max(quiet_at_, outcome.quiet_at);
    pause_ = outcome.quiet_at - outcome.ended_at;
    if (!outcome.response.empty()) hash_ = frame_hash(outcome.response.pdu());
    if (outcome.status != Status::ok) return;
    const AnswerShape shape = answer_shape(outcome.request);
    if (shape != shape_ || outcome.request.repeated) in_step_at_ = outcome.sent_at;
    shape_ = shape;
}

void StepWatch::on_late(Instant t, const AnswerShape& shape) {
    if (shape != shape_) in_step_at_ = t;
    shape_ = shape;
    quiet_at_ = std::max(quiet_at_, t + pause_);
}

// More of them may follow. A unit that is behind may repeat its last response, too: only a frame that names
// what was read before ends the doubt about it.
std::optional<Instant> StepWatch::on_surplus(const SurplusFrame& frame) {
    in_a_row_ = frame.at <= after(surplus_at_, kInterval) ? in_a_row_ + 1 : 0;
    surplus_at_ = frame.at;
    drained_ = false;
    quiet_at_ = std::max(quiet_at_, frame.at + pause_);
    alert_until_ = frame.at + kAlert;
    if (frame.hash == hash_) return std::nullopt;
    return std::exchange(in_step_at_, frame.at);
}

// A unit that often answers twice would answer a read of another shape with a copy, and seem to fail.
Instant StepWatch::earliest(Instant t, const AnswerShape& shape, Duration interval) const {
    if (t >= quiet_at_) return t;
    const bool recent = t <= after(surplus_at_, kInterval);
    const bool often = recent && in_a_row_ > 0;
    if (often && (!drained_ || in_a_row_ > kMostHalvings)) return quiet_at_;
    if (shape != shape_) return t;
    if (!drained_) return quiet_at_;
    if (t < alert_until_) interval = kAlertInterval / (1U << (recent ? in_a_row_ : 0));
    return t - in_step_at_ >= interval ? quiet_at_ : t;
}

}  // namespace takt::bus
