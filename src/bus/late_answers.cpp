// Invariant: for each failed request whose response may still arrive there is one entry, or all_wait_until_
// is not before its limit. An entry matches a frame by unit, function and one of two lengths; length 0
// matches all.
#include "takt/bus/late_answers.hpp"

#include <algorithm>

namespace takt::bus {
namespace {

bool same_length(std::size_t a, std::size_t b) {
    return a == 0 || b == 0 || a == b;
}

}  // namespace

bool LateAnswers::Expected::may_be(UnitId of, const AnswerShape& frame) const {
    return unit == of && shape.function == frame.function &&
           (same_length(shape.pdu_length, frame.pdu_length) || same_length(other_length, frame.pdu_length));
}

void LateAnswers::expect(UnitId unit, const AnswerShape& shape, Instant until) {
    if (expected_.full()) {
        all_wait_until_ = std::max(all_wait_until_, expected_[0].until);
        expected_.drop_front(1);
    }
    expected_.push_back({unit, shape, shape.pdu_length, until});
}

// The exception was one of the expected responses or that of the current request. Either way as many are
// outstanding as before: the number of entries stays. Of two such exceptions in a row the length is unknown.
void LateAnswers::expect_either(UnitId unit, const AnswerShape& current, Instant until) {
    for (auto& expected : expected_) {
        if (expected.unit != unit || expected.shape.function != current.function) continue;
        const bool first = expected.other_length == expected.shape.pdu_length;
        expected.other_length = first || expected.other_length == current.pdu_length ? current.pdu_length : 0;
        expected.until = std::max(expected.until, until);
    }
}

void LateAnswers::expire(Instant t) {
    const auto* kept =
        std::remove_if(expected_.begin(), expected_.end(), [t](const auto& e) { return e.until <= t; });
    expected_.resize(static_cast<std::size_t>(kept - expected_.begin()));
}

bool LateAnswers::settle(UnitId unit, Bytes pdu) {
    if (pdu.empty()) return false;
    const AnswerShape shape{wire::requested_function(pdu[0]), wire::is_exception(pdu[0]) ? 0 : pdu.size()};
    auto* found = std::find_if(expected_.begin(), expected_.end(),
                               [&](const auto& e) { return e.may_be(unit, shape); });
    if (found == expected_.end()) return false;
    std::copy(found + 1, expected_.end(), found);
    expected_.pop_back();
    return true;
}

bool LateAnswers::ambiguous(UnitId unit, std::uint8_t function) const {
    return std::any_of(expected_.begin(), expected_.end(),
                       [&](const auto& e) { return e.unit == unit && e.shape.function == function; });
}

Instant LateAnswers::earliest(UnitId unit, const AnswerShape& shape) const {
    Instant earliest = all_wait_until_;
    for (const auto& expected : expected_)
        if (expected.may_be(unit, shape)) earliest = std::max(earliest, expected.until);
    return earliest;
}

void LateAnswers::clear() {
    expected_.clear();
    all_wait_until_ = Instant::min();
}

}  // namespace takt::bus
