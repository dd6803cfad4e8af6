#include "takt/app/commands.hpp"
#include "takt/app/comparison_report.hpp"
#include "takt/app/plan_report.hpp"
#include "takt/app/project.hpp"
#include "takt/app/texts.hpp"

namespace takt::app {

ExitCode plan(const CommonOptions& common, const PlanOptions& options) {
    const Texts texts(common.language);
    const auto loaded = load_project(options.file);
    const auto planned = loaded.has_errors() ? plan::Plan() : plan::make_plan(loaded.project);
    if (options.json) {
        auto object = file::Json::object();
        object.set("lines", plan_json(texts, loaded.project, planned, options.compare));
        object.set("findings", findings_json(texts, loaded));
        print(object.dump() + '\n');
    } else {
        talk(findings_text(texts, loaded));
        if (!loaded.has_errors())
            print(options.compare ? comparison_text(texts, loaded.project, planned)
                                  : plan_text(texts, loaded.project, planned));
    }
    if (!loaded.readable) return ExitCode::usage;
    return loaded.has_errors() ? ExitCode::no : ExitCode::ok;
}

}  // namespace takt::app
