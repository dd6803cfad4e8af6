#include "commands.hpp"

#include <unistd.h>

#include <optional>

#include "output.hpp"
#include "progress.hpp"
#include "takt/file/write.hpp"
#include "takt/host/project_file.hpp"
#include "takt/line/loop.hpp"
#include "takt/plan/applied_measures.hpp"
#include "takt/report/plans/comparison_report.hpp"
#include "takt/report/plans/findings_report.hpp"
#include "takt/report/plans/guarantee_report.hpp"
#include "takt/report/plans/plan_csv.hpp"
#include "takt/report/plans/plan_report.hpp"
#include "takt/report/plans/plan_svg.hpp"
#include "texts.hpp"

namespace takt::app {
namespace {

using Applied = std::optional<plan::AppliedMeasures>;

void print_plan(const Texts& texts, const host::LoadedProject& loaded, const plan::Proof& proof,
                const PlanOptions& options, const Applied& applied) {
    if (options.csv)
        return print_raw(
            report::plan_csv(applied ? report::applied_json(texts, *applied)
                                     : report::project_plan_json(texts, loaded, proof, nullptr, false)));
    if (options.compare)
        return print(report::comparison_text(texts, loaded.project, proof.plan, columns_of(STDOUT_FILENO)));
    report::TableStyle style{.figures = options.prove ? report::Figures::proof : report::Figures::usual};
    style.columns = columns_of(STDOUT_FILENO);
    if (applied) return print_wrapped(report::applied_text(texts, loaded.project, proof, *applied, style));
    print_wrapped(report::plan_text(texts, loaded.project, proof.plan, proof.lines, style) +
                  report::measures_text(texts, loaded.project, proof));
}

std::string file_name(const std::string& path) {
    return path.substr(path.rfind('/') + 1);
}

/// Draws the plan into its file, or to stdout instead of the text.
ExitCode draw(const Texts& texts, const PlanOptions& options, const model::Project& project,
              const plan::Plan& plan) {
    const std::string picture = report::plan_svg(texts, file_name(options.file), project, plan);
    if (options.svg == "-" && !options.json) {
        print_raw(picture);
    } else if (const auto written = file::write_file(options.svg, picture, true); !written) {
        return ended_by(texts, written.error());
    }
    return ExitCode::ok;
}

/// A project with errors has no plan: only its findings are printed.
ExitCode refuse_plan(const Texts& texts, const host::LoadedProject& loaded, const PlanOptions& options) {
    if (options.json)
        print(report::no_plan_json(texts, loaded).dump() + '\n');
    else
        print_status(report::findings_text(texts, loaded));
    return loaded.readable ? ExitCode::no : ExitCode::usage;
}

}  // namespace

ExitCode plan(const CommonOptions& common, const PlanOptions& options) {
    const Instant start = line::now();
    const Texts texts(common.language);
    auto loaded = host::load_project(options.file);
    static_cast<void>(host::recall_learnt(loaded, options.file));
    if (loaded.has_errors()) return refuse_plan(texts, loaded, options);
    const auto proof = prove(texts, loaded, options.prove, true, start);
    Applied applied;
    if (options.fix) applied = plan::apply_measures(loaded.project, proof, options.prove);
    host::add_findings(loaded, applied ? applied->proof : proof);
    if (options.json) {
        print(report::project_plan_json(texts, loaded, proof, applied ? &*applied : nullptr, options.compare)
                  .dump() +
              '\n');
    } else {
        print_status(report::findings_text(
            texts, loaded, options.no_notes ? model::Severity::warning : model::Severity::note));
        if (options.svg != "-") print_plan(texts, loaded, proof, options, applied);
    }
    auto drawn = ExitCode::ok;
    if (!options.svg.empty())
        drawn = applied ? draw(texts, options, applied->project, applied->proof.plan)
                        : draw(texts, options, loaded.project, proof.plan);
    if (drawn != ExitCode::ok) return drawn;
    return loaded.has_errors() ? ExitCode::no : ExitCode::ok;
}

}  // namespace takt::app
