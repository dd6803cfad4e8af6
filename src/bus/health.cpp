// A device (or a request) is answering until `attempts` failures in a row. Then each failed probe doubles the
// back-off up to its limit; any answer resets both.
#include "takt/bus/health.hpp"

namespace takt::bus {

bool Health::answered() {
    const bool recovered = !answering();
    failures_ = 0;
    backoff_.reset();
    return recovered;
}

bool Health::failed(Instant t) {
    const bool was_answering = answering();
    if (was_answering) ++failures_;
    if (answering()) return false;
    probe_wait_ = backoff_.next();
    probe_at_ = after(t, probe_wait_);
    return was_answering;
}

Duration Health::probe_period(Duration period) const {
    return period > Duration::zero() ? period : backoff_.first();
}

std::optional<Instant> Health::early_probe_at(Instant last, Duration period) const {
    const Duration distance = probe_period(period);
    if (distance >= probe_wait_) return std::nullopt;
    return after(last, distance);
}

bool Health::read_started(Instant t, Duration period) {
    const bool early = !answering() && t < probe_at_;
    if (early) probe_at_ = std::max(probe_at_, after(t, probe_period(period)));
    return early;
}

bool Health::probe_now(Instant t) {
    if (answering()) return false;
    probe_at_ = std::min(probe_at_, t);
    return true;
}

}  // namespace takt::bus
