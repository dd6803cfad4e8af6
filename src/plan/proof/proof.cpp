#include "takt/plan/proof.hpp"

#include <algorithm>
#include <utility>

#include "takt/plan/guarantee_findings.hpp"
#include "timing/streams.hpp"

namespace takt::plan {
namespace {

constexpr std::size_t kShareOfMeasures = 8;  // of the progress, where planning and proving take 1 each

Duration age_with_failures(const LineGuarantee& proved, const Request& request) {
    Duration greatest{};
    for (const auto v : request.variables) {
        const auto& ages = proved.ages_with_failures;
        const auto age = request.device < ages.size() ? ages[request.device].at(v) : std::nullopt;
        greatest = std::max(greatest, age.value_or(RefreshBound::kUnbounded));
    }
    return greatest;
}

}  // namespace

bool Proof::has_errors() const {
    return std::ranges::any_of(findings, [](const auto& f) { return f.severity == model::Severity::error; });
}

void put_refresh_bounds(LinePlan& line, const LineGuarantee& proved) {
    if (!proved.feasible) return;
    for (std::size_t r = 0; r < line.requests.size(); ++r) {
        auto& request = line.requests[r];
        const auto& response = proved.requests[r].response;
        if (is_periodic(request) && response)
            request.refresh_bound =
                RefreshBound{*request.period + *response, age_with_failures(proved, request)};
    }
}

void put_ages(Plan& plan, const std::vector<LineGuarantee>& lines) {
    for (std::size_t i = 0; i < lines.size(); ++i) {
        if (!lines[i].feasible) continue;
        plan.lines[i].ages = lines[i].ages_with_failures;
        put_refresh_bounds(plan.lines[i], lines[i]);
    }
}

Proof prove(const model::Project& project, bool late_is_error, bool with_measures, const Progress& progress,
            std::optional<Plan> planned) {
    const std::size_t all = 2 + (with_measures ? kShareOfMeasures : 0);
    const auto part = [&](std::size_t before, std::size_t share) -> Progress {
        if (!progress) return {};
        return [&progress, all, before, share](std::size_t done, std::size_t total) {
            progress(before * total + share * done, all * total);
        };
    };
    Proof proof;
    proof.plan = planned ? *std::move(planned) : make_plan(project, {.progress = part(0, 1)});
    proof.lines = guarantee(project, proof.plan, {.progress = part(1, 1)});
    put_ages(proof.plan, proof.lines);
    proof.findings = guarantee_findings(project, proof.plan, proof.lines, late_is_error);
    if (!with_measures) return proof;
    const bool late_with_dead = std::ranges::any_of(
        proof.findings, [](const auto& f) { return f.code == "guarantee.late_with_dead"; });
    proof.measures = measures(project, proof.plan, proof.lines, late_with_dead, part(2, kShareOfMeasures));
    return proof;
}

}  // namespace takt::plan
