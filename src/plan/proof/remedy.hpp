// The steps of the measures: each changes settings of a line.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "takt/plan/measures.hpp"

namespace takt::plan {

/// Changes one line of a project in place. It counts the changes, and records them on request.
class Editor {
public:
    /// @param project  must outlive the editor
    /// @param line     the position of the line in `project`
    /// @param number   the position of the line in the project file, for the paths of the changes
    Editor(model::Project& project, std::size_t line, std::size_t number)
        : project_(project), line_(line), number_(number) {}

    [[nodiscard]] model::Project& project() { return project_; }
    [[nodiscard]] model::Line& line() { return project_.lines[line_]; }
    [[nodiscard]] std::size_t count() const { return count_; }
    [[nodiscard]] const std::vector<Change>& changes() const { return changes_; }
    /// Forgets the changes. Further ones are recorded in changes() if `recording`.
    void restart(bool recording);

    void note_project(const char* key, std::string from, std::string to);
    void note_line(const char* key, std::string from, std::string to);
    void note_device(std::size_t device, const char* key, std::string from, std::string to);
    void note_period(std::size_t device, std::size_t variable, Duration from, Duration to);

private:
    void note(std::string path, std::string name, const char* key, std::string from, std::string to);

    model::Project& project_;
    std::size_t line_;
    std::size_t number_;
    bool recording_ = false;
    std::size_t count_ = 0;
    std::vector<Change> changes_;
};

/// Makes its changes in the line of the editor; none if it would change nothing.
using Step = std::function<void(Editor&)>;

/// Steps of one kind, the mildest one first.
struct Ladder {
    std::vector<Step> steps;
    /// Each step goes further than the previous one: where it does not suffice, no milder one does.
    bool ordered = true;
    double largest_share = 0;  ///< Measure::largest_share
    /// The share of the line that the furthest step frees, about, estimated as Shares are.
    std::optional<double> relief = {};
};

/// Variables of one device.
struct Members {
    std::size_t device = 0;
    std::vector<std::size_t> variables;
};

/// What the steps of a line depend on, besides its settings.
struct Situation {
    const LinePlan& plan;
    bool overloaded = false;    ///< all tasks together need more time than the line has
    std::vector<Members> late;  ///< polled requests, if they are few
};

/// The ladders of one kind on one line, in the order of the search.
[[nodiscard]] std::vector<Ladder> ladders(MeasureKind kind, const model::Line& line, model::Profile profile,
                                          const Situation& situation);

/// Whether ladders() of that kind reads the situation.
[[nodiscard]] bool needs_plan(MeasureKind kind);

}  // namespace takt::plan
