#include "jobs.hpp"

#include "takt/base/assert.hpp"

namespace takt::poll {

Admittance::Admittance(const std::optional<model::Admission>& admission) {
    if (!admission) return;
    if (const auto made = bus::TokenBucket::create(admission->burst, admission->min_interval)) bucket = *made;
}

wire::PreparedRequest ReadJob::prepared() const {
    const auto made = wire::prepare(request);
    TAKT_ASSERT(made);  // the plan keeps the limits of its functions
    return *made;
}

}  // namespace takt::poll
