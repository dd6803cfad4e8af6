#include "jobs.hpp"

#include "takt/base/assert.hpp"

namespace takt::poll {

Admittance::Admittance(const std::optional<model::Admission>& admission) {
    if (!admission) return;
    if (const auto made = TokenBucket::create(admission->burst, admission->min_interval)) bucket = *made;
}

wire::Pdu ReadJob::pdu() const {
    const auto encoded = wire::encode(request);
    TAKT_ASSERT(encoded);  // the plan keeps the limits of its functions
    return *encoded;
}

}  // namespace takt::poll
