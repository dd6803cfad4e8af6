#include <algorithm>
#include <string>

#include "takt/app/commands.hpp"
#include "takt/app/guarantee_report.hpp"
#include "takt/app/project.hpp"
#include "takt/app/run_project.hpp"
#include "takt/app/texts.hpp"

namespace takt::app {

ExitCode run(const CommonOptions& common, const RunOptions& options) {
    const Texts texts(common.language);
    const auto loaded = load_to_run(texts, options.file);
    if (!loaded) return ExitCode::usage;
    const auto proof = prove(loaded->project, false, false);
    const auto errors = std::count_if(proof.findings.begin(), proof.findings.end(), [](const auto& finding) {
        return finding.severity == model::Severity::error;
    });
    if (errors > 0) texts.complain(texts("app.run.infeasible", {{"count", std::to_string(errors)}}));
    return run_project(texts, loaded->project, proof.plan, options);
}

}  // namespace takt::app
