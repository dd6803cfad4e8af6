// Project files, loaded and checked, with the files beside them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "takt/file/load.hpp"
#include "takt/model/findings.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/proof.hpp"

namespace takt::host {

/// The findings of a file, and its contents.
struct LoadedFile {
    std::vector<model::Finding> findings;
    std::vector<std::string> files;  ///< names for the locations of the findings
    bool readable = false;           ///< it is a document at all

    [[nodiscard]] bool has_errors() const;
};

struct LoadedProject : LoadedFile {
    /// Complete only without errors. With errors nothing may be planned, run or compiled from it. The
    /// findings are in the order of file, line, column.
    model::Project project;
    std::optional<plan::Plan> plan;  ///< if it was needed to check the project (profile owen-kc1)
};

/// @param profile  instead of the file's own
[[nodiscard]] LoadedProject load_project(const std::string& path,
                                         const std::optional<model::Profile>& profile = {});
/// From a text inside the program.
[[nodiscard]] LoadedProject load_project_text(const std::string& name, const std::string& text);
/// From a document, wherever it was read.
[[nodiscard]] LoadedProject interpreted(file::Loaded read);

/// plan::prove() of a project without errors that has not been changed since it was loaded. It is planned
/// only if it has no plan yet.
[[nodiscard]] plan::Proof prove(const LoadedProject& loaded, bool late_is_error, bool with_measures,
                                const plan::Progress& progress = {});

/// Appends the findings of the guarantees.
void add_findings(LoadedProject& loaded, const plan::Proof& proof);

/// Appends a warning for each file of an output that cannot be read, and for a secret that every user can
/// read.
void check_output_files(LoadedProject& loaded, const std::string& project_file);

/// A file that is a list of access rules.
struct LoadedAccess : LoadedFile {
    std::vector<model::AccessRule> rules;
};
[[nodiscard]] LoadedAccess load_access(const std::string& path);

/// The file of what was learnt: "plant.learnt.json" for "plant.yaml".
[[nodiscard]] std::string learnt_path(const std::string& project_file);

/// The file of retained values: "plant.state" for "plant.yaml".
[[nodiscard]] std::string default_state_path(const std::string& project_file);

/// Puts what was learnt before into a project. Errors of that file become findings, and so do devices that
/// were later than the project allows.
/// @returns the file for what will be learnt; empty if the project has errors or no lines, or there is a file
/// that cannot be used
[[nodiscard]] std::string recall_learnt(LoadedProject& loaded, const std::string& project_file);

}  // namespace takt::host
