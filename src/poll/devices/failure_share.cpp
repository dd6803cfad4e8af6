#include "takt/poll/failure_share.hpp"

#include <algorithm>

namespace takt::poll {

void FailureShare::ended(Instant t, bool answered) {
    in_row_ = answered ? 0 : in_row_ + 1;
    if (answered) answered_at_ = t;
    ++transactions_;
    if (!answered) ++failed_;
    if (of_ == Of::silence && in_row_ >= kGone && t >= after(answered_at_, kQuiet)) {
        window_ = 0;
        since_.reset();
        return;
    }
    if (in_row_ > kMostInRow) return;
    window_ = window_ << 1U | (answered ? 0U : 1U);
    few_ = failures() >= kEnd ? 0 : std::min(few_ + 1, kWindow);
    if (few_ == 0) many_at_ = t;
    if (!since_ && failures() >= kBegin) {
        since_ = t;
        failed_ = static_cast<std::uint64_t>(failures());
        transactions_ = std::min<std::uint64_t>(transactions_, kWindow);
    }
    if (since_ && few_ == kWindow && t >= after(many_at_, kQuiet)) since_.reset();
}

}  // namespace takt::poll
