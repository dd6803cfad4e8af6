// takt check: the findings of a project and of its guarantees, or of a microcontroller.
#include "commands.hpp"

#include <optional>
#include <utility>

#include "output.hpp"
#include "progress.hpp"
#include "takt/file/load.hpp"
#include "takt/host/project_file.hpp"
#include "takt/line/loop.hpp"
#include "takt/model/firmware.hpp"
#include "takt/plan/firmware_estimate.hpp"
#include "takt/report/plans/findings_report.hpp"
#include "takt/report/plans/firmware_report.hpp"
#include "takt/report/plans/outlook_report.hpp"
#include "takt/report/times/response_times_report.hpp"
#include "texts.hpp"

namespace takt::app {
namespace {

void print_findings(const Texts& texts, const host::LoadedFile& loaded, const CheckOptions& options) {
    print_wrapped(report::findings_text(texts, loaded,
                                        options.no_notes ? model::Severity::warning : model::Severity::note));
    print_status(report::findings_summary(texts, options.file, loaded.findings));
}

ExitCode check_firmware(const Texts& texts, const CheckOptions& options) {
    auto read = file::load_project(options.file);
    host::LoadedFile loaded{std::move(read.findings), read.document.files, read.readable};
    std::optional<model::Firmware> firmware;
    if (loaded.readable) {
        auto checked = model::interpret_firmware(read.document);
        loaded.findings.insert(loaded.findings.end(), checked.findings.begin(), checked.findings.end());
        if (!loaded.has_errors()) firmware = checked.firmware;
    }
    for (auto& finding : loaded.findings) finding.arguments.emplace_back("variant", "firmware");
    const auto estimate = firmware ? std::optional(plan::estimate(*firmware)) : std::nullopt;
    if (options.json) {
        auto object = report::check_json(texts, loaded);
        if (estimate) object.set("firmware", report::firmware_json(*estimate));
        print(object.dump() + '\n');
    } else {
        if (!estimate || !loaded.findings.empty()) print_findings(texts, loaded, options);
        if (estimate) print_wrapped(report::firmware_text(texts, *firmware, *estimate));
    }
    if (!loaded.readable) return ExitCode::usage;
    return estimate && estimate->holds() ? ExitCode::ok : ExitCode::no;
}

}  // namespace

ExitCode check(const CommonOptions& common, const CheckOptions& options) {
    const Instant start = line::now();
    const Texts texts(common.language);
    if (options.firmware) return check_firmware(texts, options);
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
        print_findings(texts, loaded, options);
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
