#include "topology.hpp"

#include "blueprint.hpp"
#include "takt/file/load.hpp"
#include "takt/plan/plan.hpp"

namespace takt::simtest {
namespace {

// The limits of a line's load and of a run's requests per second. More would only be slower.
constexpr double kMostUtilization = 0.7;
constexpr double kMostRequests = 25;
constexpr std::uint32_t kOverloadedPercent = 4;

ReadProject interpreted(const file::Loaded& loaded) {
    ReadProject read;
    auto findings = loaded.findings;
    if (loaded.readable) {
        model::Checked checked = model::interpret(loaded.document);
        findings.insert(findings.end(), checked.findings.begin(), checked.findings.end());
        read.project = std::move(checked.project);
    }
    for (const auto& finding : findings)
        if (finding.severity == model::Severity::error && read.error.empty())
            read.error = "line " + std::to_string(finding.location.line) + ": " + finding.path + ": " +
                         finding.code + " (" + finding.value + "; allowed: " + finding.allowed + ")";
    if (!loaded.readable && read.error.empty()) read.error = "cannot be read";
    return read;
}

bool too_much(const model::Project& project) {
    double requests = 0;
    for (const auto& line : plan::make_plan(project).lines) {
        if (line.utilization > kMostUtilization) return true;
        for (const auto& request : line.requests)
            if (request.period > Duration::zero())
                requests += 1e9 / static_cast<double>(request.period->count());
    }
    return requests > kMostRequests;
}

}  // namespace

ReadProject read_text(const std::string& text) {
    return interpreted(file::load_text("project.yaml", text));
}

ReadProject read_file(const std::string& path) {
    return interpreted(file::load_project(path));
}

Topology make_topology(std::uint64_t seed) {
    const Blueprint blueprint = draw_blueprint(seed);
    const bool overloaded = sim::Random(seed).fork(0x71).below(100) < kOverloadedPercent;
    Topology made;
    for (int slower = 1; slower <= 64; slower *= 2) {
        made.text = to_yaml(blueprint, slower);
        ReadProject read = read_text(made.text);
        made.project = std::move(read.project);
        made.error = std::move(read.error);
        if (!made.error.empty() || overloaded || !too_much(made.project)) break;
    }
    return made;
}

}  // namespace takt::simtest
