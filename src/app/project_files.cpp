#include "project_files.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iterator>

#include "takt/file/learnt.hpp"
#include "takt/file/read.hpp"
#include "takt/plan/learning.hpp"

namespace takt::app {
namespace {

std::chrono::sys_seconds wall_now() {
    return std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
}

bool learns(const model::Project& project) {
    return std::ranges::any_of(project.lines, [](const model::Line& line) { return plan::learns(line); });
}

}  // namespace

std::string learnt_path(const std::string& project_file) {
    return std::filesystem::path(project_file).replace_extension(".learnt.json").string();
}

std::string recall_learnt(LoadedProject& loaded, const std::string& project_file) {
    if (loaded.has_errors() || !learns(loaded.project)) return {};
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
    std::ranges::move(recalled.findings, std::back_inserter(loaded.findings));
    return recalled.whole ? path : std::string();
}

std::string default_state_path(const std::string& project_file) {
    return std::filesystem::path(project_file).replace_extension(".state").string();
}

}  // namespace takt::app
