#include "takt/bus/counters.hpp"

#include <algorithm>

namespace takt::bus {

void TimeStatistics::record(Duration sample) {
    ++count_;
    sum_ += sample;
    min_ = std::min(min_, sample);
    max_ = std::max(max_, sample);
}

Duration TimeStatistics::mean() const {
    return count_ ? sum_ / static_cast<std::int64_t>(count_) : Duration::zero();
}

void TransactionCounters::count(const Outcome& outcome) {
    if (outcome.sent) ++sent;
    const bool has_response = !outcome.response.empty();
    if (outcome.noise > 0) ++noisy_answers;
    noise_bytes += outcome.noise;
    switch (outcome.status) {
        case Status::ok:
            if (has_response) ++answered;
            break;
        case Status::exception:
            ++exceptions;
            ++exceptions_by_code[outcome.exception < exceptions_by_code.size() ? outcome.exception : 0];
            break;
        case Status::timeout: ++timeouts; break;
        case Status::bad_checksum: ++checksums; break;
        case Status::unexpected_reply: ++unexpected; break;
        case Status::ambiguous: ++ambiguous; break;
        case Status::link_lost:
        case Status::closed: ++link_lost; break;
        case Status::line_busy:
        case Status::cancelled: break;
    }
    if (has_response && (outcome.status == Status::ok || outcome.status == Status::exception))
        time.record(outcome.ended_at - outcome.sent_at);
}

}  // namespace takt::bus
