#include "takt/app/project.hpp"

#include <algorithm>
#include <iterator>
#include <tuple>

#include "project_files.hpp"
#include "takt/app/console.hpp"
#include "takt/file/load.hpp"
#include "takt/plan/queue_limit.hpp"
#include "takt/report/findings_report.hpp"

namespace takt::app {
namespace {

/// As if the file said `profile: NAME`.
void set_profile(model::Node& root, model::Profile profile) {
    if (root.kind != model::Node::Kind::mapping) return;
    model::Node::Entry entry;
    entry.key.kind = entry.value.kind = model::Node::Kind::scalar;
    entry.key.location = entry.value.location = root.location;
    entry.key.text = "profile";
    entry.value.text = model::name(profile);
    std::erase_if(root.entries, [](const auto& other) { return other.key.text == "profile"; });
    root.entries.push_back(std::move(entry));
}

}  // namespace

bool LoadedProject::has_errors() const {
    return !readable || std::any_of(findings.begin(), findings.end(), [](const auto& finding) {
        return finding.severity == model::Severity::error;
    });
}

LoadedProject interpreted(file::Loaded read) {
    LoadedProject loaded;
    loaded.readable = read.readable;
    loaded.files = read.document.files;
    loaded.findings = std::move(read.findings);
    if (!loaded.readable) return loaded;
    auto checked = model::interpret(read.document);
    loaded.project = std::move(checked.project);
    std::move(checked.findings.begin(), checked.findings.end(), std::back_inserter(loaded.findings));
    if (!loaded.has_errors())
        std::ranges::move(plan::keep_to_queue(loaded.project), std::back_inserter(loaded.findings));
    std::stable_sort(loaded.findings.begin(), loaded.findings.end(), [](const auto& a, const auto& b) {
        return std::tie(a.location.file, a.location.line, a.location.column) <
               std::tie(b.location.file, b.location.line, b.location.column);
    });
    return loaded;
}

LoadedProject load_project(const std::string& path, const std::optional<model::Profile>& profile) {
    auto read = file::load_project(path);
    if (profile) set_profile(read.document.root, *profile);
    return interpreted(std::move(read));
}

LoadedProject load_project_text(const std::string& name, const std::string& text) {
    return interpreted(file::load_text(name, text));
}

void add_findings(LoadedProject& loaded, const plan::Proof& proof) {
    loaded.findings.insert(loaded.findings.end(), proof.findings.begin(), proof.findings.end());
}

std::string findings_text(const Texts& texts, const LoadedProject& loaded) {
    return report::findings_text(texts, loaded.files, loaded.findings);
}

file::Json findings_json(const Texts& texts, const LoadedProject& loaded) {
    return report::findings_json(texts, loaded.files, loaded.findings);
}

std::optional<LoadedProject> load_to_run(const Texts& texts, const std::string& path, std::string* learnt) {
    auto loaded = load_project(path);
    if (learnt) *learnt = recall_learnt(loaded, path);
    print_status(findings_text(texts, loaded));
    if (loaded.has_errors()) return std::nullopt;
    return loaded;
}

}  // namespace takt::app
