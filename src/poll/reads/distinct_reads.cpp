#include "reads/distinct_reads.hpp"

namespace takt::poll {

void DistinctReads::set_requests(std::span<const plan::Request> planned) {
    planned_ = planned;
    reads_.clear();
    alternatives_.clear();
}

DistinctRead& DistinctReads::of(std::size_t request) {
    if (request >= reads_.size()) reads_.resize(tables_.requests.size());
    if (!reads_[request]) {
        const auto& run = tables_.requests[request];
        if (alternatives_.empty()) alternatives_.resize(tables_.devices.size());
        auto& alternatives = alternatives_[run.device];
        if (!alternatives)
            alternatives = HeapOptional(
                plan::AlternativeReads(project_, line_, *tables_.devices[run.device].model, planned_));
        reads_[request] = HeapOptional(DistinctRead(alternatives->of(*run.plan)));
    }
    return *reads_[request];
}

DistinctReads::Ended DistinctReads::ended(std::size_t request, const OutcomeClass& outcome_class) {
    if (!known(request)) return Ended::planned;
    auto& read = *reads_[request];
    const bool ok = outcome_class.reason == value::Reason::ok;
    const bool whole = read.whole();
    if (ok && whole) read.on_answered();
    if (!read.sent() || outcome_class.transient()) return Ended::planned;
    if (!ok) {
        read.on_refused();
        return Ended::other;
    }
    if (whole) return Ended::planned;
    read.on_part_answered();
    return read.sent()->kind == plan::ReadAlternative::Kind::part ? Ended::part : Ended::other;
}

}  // namespace takt::poll
