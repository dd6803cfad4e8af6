#include "devices/rate_limited_event.hpp"

namespace takt::poll {

RateLimitedEvent::RateLimitedEvent(const std::optional<model::RateLimit>& admission) {
    if (!admission) return;
    if (const auto made = TokenBucket::create(admission->burst, admission->min_interval)) bucket = *made;
}

}  // namespace takt::poll
