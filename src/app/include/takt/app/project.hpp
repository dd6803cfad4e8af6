// A project file, loaded and checked.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "takt/app/texts.hpp"
#include "takt/file/json.hpp"
#include "takt/file/load.hpp"
#include "takt/model/findings.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/proof.hpp"

namespace takt::app {

/// A project with everything found wrong, in its file and in what it says.
struct LoadedProject {
    model::Project project;
    std::vector<model::Finding> findings;  ///< in order of file, line, column
    std::vector<std::string> files;        ///< for the findings' places
    bool readable = false;                 ///< the file is a document at all

    [[nodiscard]] bool has_errors() const;
};

/// @param profile  instead of the file's own
[[nodiscard]] LoadedProject load_project(const std::string& path,
                                         const std::optional<model::Profile>& profile = {});
/// From a text inside the program.
[[nodiscard]] LoadedProject load_project_text(const std::string& name, const std::string& text);

/// From what has been read, whatever it was read from.
[[nodiscard]] LoadedProject interpreted(file::Loaded read);

/// Appends the findings of the guarantees.
void add_findings(LoadedProject& loaded, const plan::Proof& proof);

/// The findings as report::findings_text() and report::findings_json() give them.
[[nodiscard]] std::string findings_text(const Texts& texts, const LoadedProject& loaded);
[[nodiscard]] file::Json findings_json(const Texts& texts, const LoadedProject& loaded);

/// Loads a project that is to be run: its findings go to stderr; nothing when there is an error among them.
/// @param learnt  nullptr, or becomes recall_learnt() (project_files.hpp) of it
[[nodiscard]] std::optional<LoadedProject> load_to_run(const Texts& texts, const std::string& path,
                                                       std::string* learnt = nullptr);

}  // namespace takt::app
