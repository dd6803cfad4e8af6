#include "takt/plan/applied_measures.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

namespace takt::plan {
namespace {

const Measure* first_of_plan(const Proof& proof, std::size_t line) {
    const auto own = measures_of(proof.measures.found, line);
    const auto found = std::ranges::find_if(own, &Measure::only_plan);
    return found == own.end() ? nullptr : &*found;
}

/// The changes of several measures. Those of several lines may change the same key of the project.
class Changes {
public:
    void add(const std::vector<Change>& added) {
        for (const auto& change : added)
            if (known_.emplace(change.path, change.key).second) changes_.push_back(change);
    }
    [[nodiscard]] std::vector<Change> take() { return std::move(changes_); }

private:
    std::set<std::pair<std::string, std::string>> known_;  // path, key
    std::vector<Change> changes_;
};

}  // namespace

AppliedMeasures apply_measures(const model::Project& project, const Proof& proof, bool late_is_error) {
    AppliedMeasures made{.project = project, .proof = proof};
    Changes changes;
    for (const auto& line : proof.lines) {
        const auto* const measure = first_of_plan(proof, line.line);
        if (!measure) {
            if (!line.feasible) made.not_helped.push_back(line.line);
            continue;
        }
        measure->apply(made.project);
        changes.add(measure->changes);
    }
    made.changes = changes.take();
    if (!made.changes.empty()) made.proof = prove(made.project, late_is_error, false);
    return made;
}

}  // namespace takt::plan
