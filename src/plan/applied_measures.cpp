#include "takt/plan/applied_measures.hpp"

#include <algorithm>

namespace takt::plan {
namespace {

const Measure* first_of_plan(const Proof& proof, std::size_t line) {
    const auto found = std::ranges::find_if(
        proof.measures, [line](const Measure& m) { return m.line == line && m.only_plan(); });
    return found == proof.measures.end() ? nullptr : &*found;
}

/// Measures of several lines may change the same key of the project.
void add_changes(std::vector<Change>& changes, const std::vector<Change>& added) {
    for (const auto& change : added) {
        const bool known = std::ranges::any_of(changes, [&](const Change& other) {
            return other.path == change.path && other.key == change.key;
        });
        if (!known) changes.push_back(change);
    }
}

}  // namespace

AppliedMeasures apply_measures(const model::Project& project, const Proof& proof, bool late_is_error) {
    AppliedMeasures made{.project = project, .proof = proof};
    for (const auto& line : proof.lines) {
        const auto* const measure = first_of_plan(proof, line.line);
        if (!measure) {
            if (!line.feasible) made.not_helped.push_back(line.line);
            continue;
        }
        made.project.lines[line.line] = measure->project.lines[line.line];
        made.project.derive_timeouts = made.project.derive_timeouts || measure->project.derive_timeouts;
        add_changes(made.changes, measure->changes);
    }
    if (!made.changes.empty()) made.proof = prove(made.project, late_is_error, false);
    return made;
}

}  // namespace takt::plan
