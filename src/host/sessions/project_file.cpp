#include "takt/host/project_file.hpp"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <tuple>
#include <utility>

#include "engine/wall_clock.hpp"
#include "takt/bus/outstanding_responses.hpp"
#include "takt/file/learnt.hpp"
#include "takt/file/read.hpp"
#include "takt/plan/guarantee.hpp"
#include "takt/plan/queue_limit.hpp"

namespace takt::host {
namespace {

/// As if the file had the line `profile: NAME`.
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

/// A file as it was read; its contents are not interpreted yet.
void take(LoadedFile& loaded, file::Loaded& read) {
    loaded.readable = read.readable;
    loaded.files = read.document.files;
    loaded.findings = std::move(read.findings);
}

/// Of devices whose late responses would be late with this project too.
void add_late_devices(LoadedProject& loaded) {
    const auto& project = loaded.project;
    std::size_t most = 20;
    for (std::size_t l = 0; l < project.lines.size(); ++l)
        for (std::size_t d = 0; d < project.lines[l].devices.size(); ++d) {
            const auto& device = project.lines[l].devices[d];
            const auto& measured = device.times.measured;
            const Duration usual = measured.usual_lateness();
            const Duration wait = plan::answer_wait(project, project.lines[l], device);
            const bool derived = project.derive_timeouts && !device.response_timeout_set;
            const bool grows = device.learn_turnaround && derived;
            if (usual <= wait || grows || most == 0) continue;
            --most;
            const bool by_turnaround = derived && device.turnaround;
            const auto milliseconds = [](Duration time) {
                return std::to_string(std::chrono::ceil<std::chrono::milliseconds>(time).count());
            };
            const Duration advised = bus::advised_timeout(usual);
            const auto later = measured.later_than(advised);
            const Duration limit = by_turnaround ? *device.turnaround : device.response_timeout;
            loaded.findings.push_back(
                {.severity = model::Severity::warning,
                 .code = "learnt.late",
                 .location = device.location,
                 .path = "lines[" + std::to_string(l) + "].devices[" + std::to_string(d) + "]",
                 .value = milliseconds(measured.lateness) + " ms",
                 .allowed = {},
                 .arguments = {{"device", device.name},
                               {"setting", by_turnaround ? "turnaround" : "response_timeout"},
                               {"limit", milliseconds(limit) + " ms"},
                               {"advised", milliseconds(advised) + "ms"},
                               {"count", std::to_string(measured.late)},
                               {"later", std::to_string(later)}}});
            if (later == 0) loaded.findings.back().arguments.emplace_back("variant", "none_later");
        }
}

}  // namespace

bool LoadedFile::has_errors() const {
    return !readable || std::any_of(findings.begin(), findings.end(), [](const auto& finding) {
        return finding.severity == model::Severity::error;
    });
}

LoadedProject interpreted(file::Loaded read) {
    LoadedProject loaded;
    take(loaded, read);
    if (!loaded.readable) return loaded;
    auto checked = model::interpret(read.document);
    loaded.project = std::move(checked.project);
    std::move(checked.findings.begin(), checked.findings.end(), std::back_inserter(loaded.findings));
    if (!loaded.has_errors()) {
        auto limit = plan::keep_to_queue(loaded.project);
        loaded.plan = std::move(limit.plan);
        std::ranges::move(limit.findings, std::back_inserter(loaded.findings));
    }
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

plan::Proof prove(const LoadedProject& loaded, bool late_is_error, bool with_measures,
                  const plan::Progress& progress) {
    return plan::prove(loaded.project, late_is_error, with_measures, progress, loaded.plan);
}

void add_findings(LoadedProject& loaded, const plan::Proof& proof) {
    loaded.findings.insert(loaded.findings.end(), proof.findings.begin(), proof.findings.end());
}

LoadedAccess load_access(const std::string& path) {
    auto read = file::load_project(path);
    LoadedAccess loaded;
    take(loaded, read);
    if (!loaded.readable) return loaded;
    auto checked = model::interpret_access(read.document);
    loaded.rules = std::move(checked.rules);
    std::ranges::move(checked.findings, std::back_inserter(loaded.findings));
    return loaded;
}

std::string learnt_path(const std::string& project_file) {
    return std::filesystem::path(project_file).replace_extension(".learnt.json").string();
}

std::string recall_learnt(LoadedProject& loaded, const std::string& project_file) {
    if (loaded.has_errors() || loaded.project.lines.empty()) return {};
    std::string path = learnt_path(project_file);
    std::error_code trouble;
    if (!std::filesystem::exists(path, trouble) && !trouble) return path;
    const auto file = static_cast<std::uint32_t>(loaded.files.size());
    loaded.files.push_back(path);
    const auto text = file::read_file(path, file::kMaxLearntBytes);
    if (!text) {
        loaded.findings.push_back({.severity = model::Severity::warning,
                                   .code = "learnt.unreadable",
                                   .location = {.file = file},
                                   .path = {},
                                   .value = std::string(name(text.error().code)),
                                   .allowed = {},
                                   .arguments = {}});
        return {};
    }
    auto recalled = file::recall(*text, wall_now(), file, loaded.project);
    loaded.plan.reset();
    std::ranges::move(recalled.findings, std::back_inserter(loaded.findings));
    add_late_devices(loaded);
    return recalled.whole ? path : std::string();
}

std::string default_state_path(const std::string& project_file) {
    return std::filesystem::path(project_file).replace_extension(".state").string();
}

}  // namespace takt::host
