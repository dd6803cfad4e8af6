#include "takt/poll/failure_share.hpp"

namespace takt::poll {

void FailureShare::ended(Instant t, bool answered) {
    in_row_ = answered ? 0 : in_row_ + 1;
    if (answered) answered_at_ = t;
    if (in_row_ >= kGone && t >= after(answered_at_, kQuiet)) {
        window_ = 0;
        since_.reset();
        return;
    }
    if (in_row_ > kMostInRow) return;
    window_ = window_ << 1U | (answered ? 0U : 1U);
    if (failures() >= kBegin && !since_) since_ = t;
    if (failures() >= kEnd) many_at_ = t;
    if (since_ && t >= after(many_at_, kQuiet)) since_.reset();
}

}  // namespace takt::poll
