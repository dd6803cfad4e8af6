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
void StepWatch::on_outcome(const Outcome& outcome, bool in_order) {
    const bool came = outcome.status == Status::ok || outcome.status == Status::exception ||
                      outcome.status == Status::ambiguous;
    if (!outcome.sent || outcome.unit == kBroadcast) return;
    judge(outcome, came, in_order);
    if (!came) return;
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

void StepWatch::judge(const Outcome& outcome, bool came, bool in_order) {
    const AnswerShape shape = answer_shape(outcome.request);
    // A damaged response has come, and none comes on a connection that has ended.
    const bool missing = outcome.status == Status::timeout || outcome.status == Status::unexpected_reply;
    wait_ = outcome.wait;
    if (missing) missing_since_ = std::min(missing_since_, outcome.ended_at);
    if (heard_at_ == Instant::min()) heard_at_ = outcome.sent_at;
    const bool paused = outcome.sent_at >= after(heard_at_, doubt_time(outcome.sent_at));
    if (came) heard_at_ = std::max(heard_at_, outcome.ended_at);
    const bool ok = outcome.status == Status::ok;
    const bool other = ok && in_order && (outcome.request.repeated || !in_doubt(shape));
    const bool in_step = paused || (other && outcome.sent_at >= trouble_at_);
    if (in_step) end_doubt();
    const bool doubtful = came && !ok && outcome.sent_at < doubted_until_;
    if (missing || doubtful) note_trouble(outcome.ended_at, shape);
    if (missing) ++missing_;
}

void StepWatch::end_doubt() {
    missing_ = 0;
    doubted_until_ = Instant::min();
}

bool StepWatch::in_doubt(const AnswerShape& shape) const {
    return any_doubtful_ ||
           (shape.function == doubtful_.function &&
            (shape.pdu_length == doubtful_.pdu_length || shape.pdu_length == 0 || doubtful_.pdu_length == 0));
}

StepWatch::Proof StepWatch::proof(Instant t, const Outcome& read) const {
    if (read.ended_at <= trouble_at_) return Proof::refuted;
    return t < doubted_until(read) ? Proof::waits : Proof::proved;
}

bool StepWatch::behind(const Outcome& read) const {
    return read.ended_at < alert_until_ && read.sent_at > in_step_at_;
}

Instant StepWatch::doubted_until(const Outcome& read) const {
    const Instant doubted = in_doubt(answer_shape(read.request)) ? doubted_until_ : Instant::min();
    return behind(read) ? std::max(doubted, quiet_at_) : doubted;
}

void StepWatch::note_trouble(Instant t, const AnswerShape& shape) {
    if (t >= doubted_until_) {
        missing_ = 0;
        doubtful_ = shape;
        any_doubtful_ = false;
    } else if (!in_doubt(shape)) {
        any_doubtful_ = true;
    }
    trouble_at_ = std::max(trouble_at_, t);
    doubted_until_ = std::max(doubted_until_, after(t, doubt_time(t)));
}

Duration StepWatch::doubt_time(Instant t) const {
    const Duration longest = OutstandingResponses::confirmation_time(wait_);
    const bool may_be_late = t < after(missing_since_, 2 * longest) || t < after(late_at_, kAlert);
    return may_be_late ? longest : std::min(longest, kInterval);
}

void StepWatch::on_late(Instant t, const AnswerShape& shape) {
    late_at_ = heard_at_ = t;
    note_trouble(t, shape);
    if (missing_ > 0) --missing_;
    if (missing_ == 0) end_doubt();
    if (shape != shape_) in_step_at_ = t;
    shape_ = shape;
    quiet_at_ = std::max(quiet_at_, t + pause_);
}

// More of them may follow. A unit that is behind may repeat its last response, too: only a frame that names
// what was read before ends the doubt about it.
std::optional<Instant> StepWatch::on_surplus(const SurplusFrame& frame) {
    heard_at_ = frame.at;
    in_a_row_ = frame.at <= after(surplus_at_, kInterval) ? in_a_row_ + 1 : 0;
    surplus_at_ = frame.at;
    drained_ = false;
    quiet_at_ = std::max(quiet_at_, frame.at + pause_);
    alert_until_ = frame.at + kAlert;
    if (frame.hash == hash_) return std::nullopt;
    if (frame.at < doubted_until_) note_trouble(frame.at, frame.shape);
    trouble_at_ = frame.at;
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
