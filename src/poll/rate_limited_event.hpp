// The read half of a request of the plan, and what both halves share.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/base/token_bucket.hpp"
#include "takt/bus/counters.hpp"
#include "takt/bus/health.hpp"
#include "takt/bus/release.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/model/project.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::poll {

using bus::Backoff;
using bus::busy_backoff;
using bus::Health;
using bus::PeriodicRelease;
using bus::PeriodMeter;

/// Numbers commands and triggers in the order of their arrival.
class ArrivalCounter {
public:
    [[nodiscard]] std::uint64_t next() { return ++last_; }

private:
    std::uint64_t last_ = 0;
};

/// The admission of an event (a command, a trigger, a change) to the queue, at the rate of its token bucket.
/// Events that arrive while one waits are merged with it.
struct RateLimitedEvent {
    std::optional<TokenBucket> bucket;
    std::optional<Duration> deadline;  // of what the bucket admits
    bool admitted = false;
    std::uint64_t order = 0;  // of arrival, among commands and triggers

    RateLimitedEvent() = default;
    explicit RateLimitedEvent(const std::optional<model::RateLimit>& admission);

    /// An event arrives while none waits.
    void arrive(Instant t, std::uint64_t next_order) {
        order = next_order;
        admitted = !bucket || bucket->admit(t);
    }
    /// Whether it is in the queue, or enters it now.
    bool admit(Instant t) {
        if (!admitted) admitted = !bucket || bucket->admit(t);
        return admitted;
    }
};

/// The read half of a request of the plan; ReadSchedule has its schedule.
struct ReadJob {
    wire::PreparedRead request;
    std::size_t rank = 0;   // among all jobs of the line, in the order of the plan
    Duration deadline{};    // relative to the release
    bool polled = false;    // by period
    unsigned refusals = 0;  // in a row, of a read across gaps
    Instant last_start = Instant::min();

    [[nodiscard]] bus::AnswerShape shape() const { return bus::answer_shape(request.shape()); }
};

/// The shape of the answer to a write of one register.
inline bus::AnswerShape written_shape(wire::Function function) {
    return bus::answer_shape(function, 1);
}

}  // namespace takt::poll
