#include "takt/app/commands.hpp"
#include "takt/app/project.hpp"
#include "takt/app/run_project.hpp"
#include "takt/app/texts.hpp"

namespace takt::app {

ExitCode run(const CommonOptions& common, const RunOptions& options) {
    const Texts texts(common.language);
    const auto loaded = load_to_run(texts, options.file);
    if (!loaded) return ExitCode::usage;
    const auto planned = plan::make_plan(loaded->project);
    return run_project(texts, loaded->project, planned, options);
}

}  // namespace takt::app
