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

}  // namespace takt::bus
