#include "takt/app/project.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <tuple>

#include "takt/app/learner.hpp"
#include "takt/file/load.hpp"
#include "takt/plan/queue_limit.hpp"

namespace takt::app {
namespace {

/// As if the file said `profile: NAME`.
void set_profile(model::Node& root, model::Profile profile) {
    if (root.kind != model::Node::Kind::mapping) return;
    model::Node::Entry entry;
    entry.key.kind = entry.value.kind = model::Node::Kind::scalar;
    entry.key.place = entry.value.place = root.place;
    entry.key.text = "profile";
    entry.value.text = model::name(profile);
    std::erase_if(root.entries, [](const auto& other) { return other.key.text == "profile"; });
    root.entries.push_back(std::move(entry));
}

std::string place_text(const LoadedProject& loaded, const model::Place& place) {
    std::string text = place.file < loaded.files.size() ? loaded.files[place.file] : std::string("?");
    if (place.line > 0) text += fmt::format(":{}:{}", place.line, place.column);
    return text;
}

const char* severity_name(model::Severity severity) {
    return severity == model::Severity::error ? "error" : "warning";
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
        return std::tie(a.place.file, a.place.line, a.place.column) <
               std::tie(b.place.file, b.place.line, b.place.column);
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

std::string findings_text(const Texts& texts, const LoadedProject& loaded) {
    std::string text;
    for (const auto& finding : loaded.findings) {
        text += fmt::format("{}: {}: ", place_text(loaded, finding.place),
                            texts(fmt::format("app.{}", severity_name(finding.severity))));
        if (!finding.path.empty()) text += finding.path + ": ";
        text += texts.message(finding) + '\n';
        if (const auto advice = texts.advice(finding); !advice.empty()) text += "    " + advice + '\n';
    }
    return text;
}

file::Json findings_json(const Texts& texts, const LoadedProject& loaded) {
    auto list = file::Json::array();
    for (const auto& finding : loaded.findings) {
        auto object = file::Json::object();
        object.set("severity", severity_name(finding.severity));
        object.set("code", finding.code);
        object.set("file", finding.place.file < loaded.files.size() ? loaded.files[finding.place.file]
                                                                    : std::string());
        object.set("line", finding.place.line);
        object.set("column", finding.place.column);
        object.set("path", finding.path);
        object.set("value", finding.value);
        object.set("allowed", finding.allowed);
        object.set("message", texts.message(finding));
        object.set("advice", texts.advice(finding));
        list.push_back(std::move(object));
    }
    return list;
}

std::optional<LoadedProject> load_to_run(const Texts& texts, const std::string& path, std::string* learnt) {
    auto loaded = load_project(path);
    if (learnt) *learnt = recall_learnt(loaded, path);
    talk(findings_text(texts, loaded));
    if (loaded.has_errors()) return std::nullopt;
    return loaded;
}

}  // namespace takt::app
