#include "selftest/wake_up.hpp"

namespace takt::client {

WakeUp::WakeUp(line::Loop& loop, Duration pace, LatencyStatistics& statistics)
    : pace_(pace),
      statistics_(statistics),
      due_(line::now() + pace),
      timer_(loop, [this](Instant t) { expire(t); }) {
    timer_.set(due_);
}

void WakeUp::expire(Instant t) {
    statistics_.record(t - due_);
    const auto passed = (t - due_) / pace_;
    due_ += pace_ * (passed + 1);
    timer_.set(due_);
}

}  // namespace takt::client
