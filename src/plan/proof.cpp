#include "takt/plan/proof.hpp"

#include <algorithm>

#include "takt/plan/guarantee_findings.hpp"

namespace takt::plan {

bool Proof::has_errors() const {
    return std::ranges::any_of(findings, [](const auto& f) { return f.severity == model::Severity::error; });
}

Proof prove(const model::Project& project, bool late_is_error, bool with_measures) {
    Proof proof;
    proof.plan = make_plan(project);
    proof.lines = guarantee(project, proof.plan);
    proof.findings = guarantee_findings(project, proof.plan, proof.lines, late_is_error);
    if (!with_measures) return proof;
    const bool late_with_dead = std::ranges::any_of(
        proof.findings, [](const auto& f) { return f.code == "guarantee.late_with_dead"; });
    proof.measures = measures(project, proof.lines, late_with_dead);
    return proof;
}

}  // namespace takt::plan
