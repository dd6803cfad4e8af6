// Triggers, writes and changes that wait to be sent: their order and their admission.
#pragma once

#include <cstdint>
#include <optional>

#include "takt/base/time.hpp"
#include "takt/base/token_bucket.hpp"
#include "takt/model/project.hpp"

namespace takt::poll {

/// Numbers commands and triggers in the order of their arrival.
class ArrivalCounter {
public:
    [[nodiscard]] std::uint64_t next() { return ++last_; }

private:
    std::uint64_t last_ = 0;
};

/// The admission of an event (a command, a trigger, a change) to the queue, at the rate of its token bucket.
/// Events that arrive while one waits are merged with it. Its owner decides when it waits no more. Never
/// allocates.
struct RateLimitedEvent {
    std::optional<TokenBucket> bucket;
    std::optional<Duration> deadline;  ///< of what the bucket admits
    bool admitted = false;
    std::uint64_t order = 0;  ///< of arrival, among commands and triggers

    RateLimitedEvent() = default;
    /// @param admission  nothing: every event is admitted at once
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

}  // namespace takt::poll
