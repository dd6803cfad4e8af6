#include "takt/app/check_command.hpp"

#include "takt/app/console.hpp"
#include "takt/app/project.hpp"
#include "takt/app/texts.hpp"
#include "takt/plan/proof.hpp"

namespace takt::app {
namespace {

std::string count_of(const LoadedProject& loaded, model::Severity severity) {
    std::size_t count = 0;
    for (const auto& finding : loaded.findings) count += finding.severity == severity ? 1 : 0;
    return std::to_string(count);
}

}  // namespace

ExitCode check(const CommonOptions& common, const CheckOptions& options) {
    const Texts texts(common.language);
    auto loaded = load_project(options.file);
    if (!loaded.has_errors()) add_findings(loaded, plan::prove(loaded.project, options.prove, false));
    if (options.json) {
        auto object = file::Json::object();
        object.set("findings", findings_json(texts, loaded));
        print(object.dump() + '\n');
    } else {
        print(findings_text(texts, loaded));
        print_status(texts("app.checked", {{"file", options.file},
                                           {"errors", count_of(loaded, model::Severity::error)},
                                           {"warnings", count_of(loaded, model::Severity::warning)}}) +
                     '\n');
    }
    if (!loaded.readable) return ExitCode::usage;
    return loaded.has_errors() ? ExitCode::no : ExitCode::ok;
}

}  // namespace takt::app
