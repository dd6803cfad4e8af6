// takt check: the findings of a project and of its guarantees.
#include "commands/check_command.hpp"

#include "output.hpp"
#include "progress.hpp"
#include "takt/host/project_file.hpp"
#include "takt/line/loop.hpp"
#include "takt/report/findings_report.hpp"
#include "texts.hpp"

namespace takt::app {

ExitCode check(const CommonOptions& common, const CheckOptions& options) {
    const Instant start = line::now();
    const Texts texts(common.language);
    auto loaded = host::load_project(options.file);
    if (!loaded.has_errors()) host::add_findings(loaded, prove(texts, loaded, options.prove, false, start));
    if (options.json) {
        print(report::check_json(texts, loaded).dump() + '\n');
    } else {
        print(report::findings_text(texts, loaded));
        print_status(report::findings_summary(texts, options.file, loaded.findings));
    }
    if (!loaded.readable) return ExitCode::usage;
    return loaded.has_errors() ? ExitCode::no : ExitCode::ok;
}

}  // namespace takt::app
