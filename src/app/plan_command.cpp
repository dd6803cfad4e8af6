#include "takt/app/plan_command.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <optional>

#include "takt/app/console.hpp"
#include "takt/app/learner.hpp"
#include "takt/app/project.hpp"
#include "takt/app/texts.hpp"
#include "takt/report/comparison_report.hpp"
#include "takt/report/guarantee_report.hpp"
#include "takt/report/plan_report.hpp"
#include "takt/report/plan_svg.hpp"

namespace takt::app {
namespace {

/// What `--fix` makes of a project: the settings that change only the plan, and what is proved with them.
struct Fixed {
    model::Project project;
    std::vector<plan::Change> changes;
    std::vector<std::size_t> without;  // lines that no such change helps
    plan::Proof proof;
};

const plan::Measure* first_of_plan(const plan::Proof& proof, std::size_t line) {
    for (const auto& measure : proof.measures)
        if (measure.line == line && measure.only_plan()) return &measure;
    return nullptr;
}

Fixed fixed(const model::Project& project, const plan::Proof& proof, bool prove_all) {
    Fixed made{.project = project, .proof = proof};
    for (const auto& line : proof.lines) {
        const bool helped = line.feasible && !first_of_plan(proof, line.line);
        if (helped) continue;
        const auto* measure = first_of_plan(proof, line.line);
        if (!measure) {
            made.without.push_back(line.line);
            continue;
        }
        made.project.lines[line.line] = measure->project.lines[line.line];
        made.project.derive_timeouts = made.project.derive_timeouts || measure->project.derive_timeouts;
        for (const auto& change : measure->changes) {
            const bool known = std::any_of(made.changes.begin(), made.changes.end(), [&](const auto& other) {
                return other.path == change.path && other.key == change.key;
            });
            if (!known) made.changes.push_back(change);
        }
    }
    if (!made.changes.empty()) made.proof = plan::prove(made.project, prove_all, false);
    return made;
}

std::string fixed_text(const Texts& texts, const model::Project& before, const plan::Proof& proof,
                       const Fixed& fix) {
    std::string text;
    for (const std::size_t line : fix.without)
        text += texts("app.fix.none", {{"line", before.lines[line].name}}) + '\n';
    if (fix.changes.empty()) return fix.without.empty() ? texts("app.fix.nothing") + '\n' : text;
    text += texts("app.fix.before") + "\n" + report::plan_text(texts, before, proof.plan, proof.lines);
    text += '\n' + texts("app.fix.after") + "\n" +
            report::plan_text(texts, fix.project, fix.proof.plan, fix.proof.lines);
    return text + '\n' + texts("app.fix.applied") + '\n' + report::changes_text(texts, fix.changes);
}

file::Json fixed_json(const Texts& texts, const Fixed& fix) {
    auto object = file::Json::object();
    object.set("changes", report::changes_json(fix.changes));
    object.set("lines", report::plan_json(texts, fix.project, fix.proof.plan, fix.proof, false));
    return object;
}

void tell_json(const Texts& texts, const LoadedProject& loaded, const plan::Proof& proof,
               const PlanOptions& options, const std::optional<Fixed>& fix) {
    auto object = file::Json::object();
    object.set("lines", report::plan_json(texts, loaded.project, proof.plan, proof, options.compare));
    if (fix) object.set("fixed", fixed_json(texts, *fix));
    object.set("findings", findings_json(texts, loaded));
    print(object.dump() + '\n');
}

void tell(const Texts& texts, const LoadedProject& loaded, const plan::Proof& proof,
          const PlanOptions& options, const std::optional<Fixed>& fix) {
    if (options.compare) return print(report::comparison_text(texts, loaded.project, proof.plan));
    if (fix) return print(fixed_text(texts, loaded.project, proof, *fix));
    print(report::plan_text(texts, loaded.project, proof.plan, proof.lines) +
          report::measures_text(texts, loaded.project, proof));
}

Result<void> write_file(const std::string& path, const std::string& content) {
    std::FILE* const file = std::fopen(path.c_str(), "wb");
    if (!file) return fail(Code::cannot_open, path, errno);
    const bool written = std::fwrite(content.data(), 1, content.size(), file) == content.size();
    const int why = errno;
    if (std::fclose(file) != 0) return fail(Code::io_failed, path, errno);
    if (!written) return fail(Code::io_failed, path, why);
    return {};
}

std::string file_name(const std::string& path) {
    return path.substr(path.rfind('/') + 1);
}

/// Draws the plan into its file, or to stdout instead of the text.
ExitCode draw(const Texts& texts, const PlanOptions& options, const model::Project& project,
              const plan::Plan& plan) {
    const std::string picture = report::plan_svg(texts, file_name(options.file), project, plan);
    if (options.svg == "-" && !options.json) {
        print(picture);
    } else if (const auto written = write_file(options.svg, picture); !written) {
        return ended_by(texts, written.error());
    }
    return ExitCode::ok;
}

}  // namespace

ExitCode plan(const CommonOptions& common, const PlanOptions& options) {
    const Texts texts(common.language);
    auto loaded = load_project(options.file);
    static_cast<void>(recall_learnt(loaded, options.file));
    const bool sound = !loaded.has_errors();
    const auto proof = sound ? plan::prove(loaded.project, options.prove, true) : plan::Proof();
    const auto fix =
        options.fix && sound ? std::optional(fixed(loaded.project, proof, options.prove)) : std::nullopt;
    add_findings(loaded, fix ? fix->proof : proof);
    if (options.json) {
        tell_json(texts, loaded, proof, options, fix);
    } else {
        print_status(findings_text(texts, loaded));
        if (sound && options.svg != "-") tell(texts, loaded, proof, options, fix);
    }
    if (!loaded.readable) return ExitCode::usage;
    auto drawn = ExitCode::ok;
    if (sound && !options.svg.empty())
        drawn = fix ? draw(texts, options, fix->project, fix->proof.plan)
                    : draw(texts, options, loaded.project, proof.plan);
    if (drawn != ExitCode::ok) return drawn;
    return loaded.has_errors() ? ExitCode::no : ExitCode::ok;
}

}  // namespace takt::app
