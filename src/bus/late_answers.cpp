// Invariant: for each failed request whose response may still arrive there is one entry, or all_wait_until_
// is not before its limit. An entry matches a frame by unit, function and length; length 0 matches all.
#include "takt/bus/late_answers.hpp"

#include <algorithm>

namespace takt::bus {
namespace {

bool may_be_equal(const AnswerShape& a, const AnswerShape& b) {
    return a.function == b.function &&
           (a.pdu_length == 0 || b.pdu_length == 0 || a.pdu_length == b.pdu_length);
}

}  // namespace

void LateAnswers::expect(UnitId unit, const AnswerShape& shape, Instant until) {
    if (expected_.full()) {
        all_wait_until_ = std::max(all_wait_until_, expected_[0].until);
        expected_.drop_front(1);
    }
    expected_.push_back({unit, shape, until});
}

// The exception was one of the expected responses or that of the current request. Either way as many are
// outstanding as before: the number of entries stays.
void LateAnswers::expect_any(UnitId unit, std::uint8_t function, Instant until) {
    for (auto& expected : expected_) {
        if (expected.unit != unit || expected.shape.function != function) continue;
        expected.shape.pdu_length = 0;
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
                               [&](const auto& e) { return e.unit == unit && may_be_equal(e.shape, shape); });
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
        if (expected.unit == unit && may_be_equal(expected.shape, shape))
            earliest = std::max(earliest, expected.until);
    return earliest;
}

void LateAnswers::clear() {
    expected_.clear();
    all_wait_until_ = Instant::min();
}

}  // namespace takt::bus
