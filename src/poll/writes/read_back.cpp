// The read that verifies a write.
#include "writes/read_back.hpp"

#include "line/transfer.hpp"
#include "takt/plan/request_job.hpp"

namespace takt::poll {

bool ReadBack::again(Instant t, const OutcomeClass& outcome_class, std::uint16_t attempts) {
    const bool transient = outcome_class.reason != value::Reason::link_lost && outcome_class.transient();
    if (!transient || !bus::attempts_left(outcome_class.status(), attempts, failures)) return false;
    if (outcome_class.busy) not_before = after(t, busy.next());
    return true;
}

ReadBack read_back_of(const model::Variable& variable) {
    return {.request = prepared(plan::read_back_of(variable))};
}

}  // namespace takt::poll
