#include "takt/bus/scan_findings.hpp"

#include <algorithm>

namespace takt::bus {

bool is_of_setting(const Error& error) {
    return error.code == Code::unsupported || error.code == Code::out_of_range;
}

const Error* first_failure(const ScanFindings& findings) {
    const auto failure = std::ranges::find_if(findings.troubles, [](const ScanTrouble& trouble) {
        return trouble.kind == ScanTrouble::Kind::error && !is_of_setting(trouble.error);
    });
    return failure == findings.troubles.end() ? nullptr : &failure->error;
}

ScanOutcome outcome_of(const ScanFindings& findings) {
    const bool failed = first_failure(findings) != nullptr;
    if (!findings.complete) return ScanOutcome::partly;
    if (!findings.devices.empty()) return failed ? ScanOutcome::partly : ScanOutcome::found;
    if (failed) return findings.reached ? ScanOutcome::partly : ScanOutcome::failed;
    return ScanOutcome::nothing;
}

}  // namespace takt::bus
