// takt check: the findings of a project and of its guarantees.
#include "commands/check_command.hpp"

#include <optional>

#include "output.hpp"
#include "progress.hpp"
#include "takt/host/project_file.hpp"
#include "takt/line/loop.hpp"
#include "takt/report/findings_report.hpp"
#include "takt/report/outlook_report.hpp"
#include "takt/report/response_times_report.hpp"
#include "texts.hpp"

namespace takt::app {

ExitCode check(const CommonOptions& common, const CheckOptions& options) {
    const Instant start = line::now();
    const Texts texts(common.language);
    auto loaded = host::load_project(options.file);
    static_cast<void>(host::recall_learnt(loaded, options.file));
    host::check_output_files(loaded, options.file);
    std::optional<report::Outlook> outlook;
    if (!loaded.has_errors()) {
        const auto proof = prove(texts, loaded, options.prove, false, start);
        host::add_findings(loaded, proof);
        outlook = report::outlook(loaded.project, proof);
    }
    if (options.json) {
        auto object = report::check_json(texts, loaded);
        if (outlook) object.set("outlook", report::outlook_json(*outlook));
        if (auto times = report::learnt_times_json(loaded.project); times != file::Json::array())
            object.set("response_times", std::move(times));
        print(object.dump() + '\n');
    } else {
        print_wrapped(report::findings_text(
            texts, loaded, options.no_notes ? model::Severity::warning : model::Severity::note));
        print_status(report::findings_summary(texts, options.file, loaded.findings));
        if (outlook) {
            print_status(report::outlook_text(texts, loaded.project, *outlook));
            for (const auto& line : loaded.project.lines)
                print_status(report::learnt_times_text(texts, line));
        }
    }
    if (!loaded.readable) return ExitCode::usage;
    return loaded.has_errors() ? ExitCode::no : ExitCode::ok;
}

}  // namespace takt::app
