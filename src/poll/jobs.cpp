#include "jobs.hpp"

namespace takt::poll {

Admittance::Admittance(const std::optional<model::Admission>& admission) {
    if (!admission) return;
    if (const auto made = TokenBucket::create(admission->burst, admission->min_interval)) bucket = *made;
}

}  // namespace takt::poll
