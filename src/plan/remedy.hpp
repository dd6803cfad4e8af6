// The steps of the measures: each changes one setting of a line, mildest step first.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "takt/plan/measures.hpp"

namespace takt::plan {

/// Changes one line of a project in place and records the changes.
class Editor {
public:
    /// @param project  must outlive the editor
    /// @param line     the position of the line in `project`
    /// @param number   the position of the line in the project file, for the paths of the changes
    Editor(model::Project& project, std::size_t line, std::size_t number)
        : project_(project), line_(line), number_(number) {}

    [[nodiscard]] model::Project& project() { return project_; }
    [[nodiscard]] model::Line& line() { return project_.lines[line_]; }
    [[nodiscard]] const std::vector<Change>& changes() const { return changes_; }
    void forget_changes() { changes_.clear(); }

    void note_project(const char* key, std::string from, std::string to);
    void note_line(const char* key, std::string from, std::string to);
    void note_device(std::size_t device, const char* key, std::string from, std::string to);
    void note_variable(std::size_t device, std::size_t variable, std::string from, std::string to);

private:
    model::Project& project_;
    std::size_t line_;
    std::size_t number_;
    std::vector<Change> changes_;
};

/// Makes its changes in the line of the editor; none if it would change nothing.
using Step = std::function<void(Editor&)>;

/// The steps of one kind on one line, mildest first; each goes further than the previous one.
/// @param plan  of that line
[[nodiscard]] std::vector<Step> steps(MeasureKind kind, const model::Line& line, model::Profile profile,
                                      const LinePlan& plan);

/// Whether steps() of that kind reads the plan.
[[nodiscard]] bool needs_plan(MeasureKind kind);

}  // namespace takt::plan
