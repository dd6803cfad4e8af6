// The demo: a project inside the program (examples/demo.yaml), its line simulated at byte times, polled by
// the real master.
#include <unistd.h>

#include "commands/demo_project.hpp"
#include "commands/run_command.hpp"
#include "commands/run_project.hpp"
#include "output.hpp"
#include "takt/base/assert.hpp"
#include "takt/host/project_file.hpp"
#include "takt/report/comparison_report.hpp"
#include "takt/report/plan_report.hpp"
#include "texts.hpp"

namespace takt::app {
namespace {

/// The pump answers that it has no such register: the last of its variables, which the project asks for all
/// the same.
void refuse_one_register(const model::Line& line, sim::Devices& devices) {
    const auto& pump = line.devices.back();
    const auto& missing = pump.variables.back();
    devices.find(pump.address)
        ->behaviour.refusals.push_back(
            {missing.area, {missing.start(), missing.start()}, wire::ExceptionCode::illegal_data_address});
}

}  // namespace

ExitCode demo(const CommonOptions& common, const DemoOptions& options) {
    const Texts texts(common.language);
    const auto loaded = host::load_project_text("demo.yaml", std::string(kDemoProject));
    TAKT_ASSERT(!loaded.has_errors());
    const auto planned = plan::make_plan(loaded.project);
    if (!options.json) {
        const auto plan =
            report::plan_text(texts, loaded.project, planned, {}, {.columns = columns_of(STDOUT_FILENO)});
        print_wrapped(texts("app.demo.intro") + "\n\n" + plan + '\n');
        print(report::comparison_text(texts, loaded.project, planned, columns_of(STDOUT_FILENO)) + '\n');
    }
    RunOptions run;
    run.run_for = options.run_for;
    run.json = options.json;
    return run_project(texts, loaded.project, planned, run, [&](std::size_t line, sim::Devices& devices) {
        refuse_one_register(loaded.project.lines[line], devices);
    });
}

}  // namespace takt::app
