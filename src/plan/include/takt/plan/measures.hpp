// What would make an infeasible line feasible (guarantees, "What makes an infeasible project feasible"): each
// measure is a changed project, planned and proved anew.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/plan/guarantee.hpp"

namespace takt::plan {

/// In the order in which they are tried: the cheapest first.
enum class MeasureKind : std::uint8_t { time_outs, splitting, grouping, bit_rate, periods, attempts };
[[nodiscard]] std::string_view name(MeasureKind kind);

/// What a measure is to reach on a line: that nothing is late without failures, under the project's faults,
/// with the worst dead device. Each includes those before it.
enum class Goal : std::uint8_t { sound, with_faults, with_dead_device };

/// One line of the project file.
struct Change {
    std::string path;  ///< of its object: "lines[0].devices[2]"; empty: the project itself
    std::string name;  ///< of its object
    std::string key;
    std::string from;  ///< as in a project file; empty: it was not there
    std::string to;
};

struct Measure {
    std::vector<MeasureKind> kinds;  ///< one or two
    std::size_t line = 0;
    Goal goal = Goal::sound;
    std::vector<Change> changes;
    model::Project project;  ///< changed
    /// The variable that was latest, and its response then and now (of the kind the goal names).
    std::string variable;
    std::optional<Duration> before;
    std::optional<Duration> after;
    Duration deadline{};  ///< that it now holds
    double utilization_before = 0;
    double utilization_after = 0;

    /// Time-outs, splitting, grouping: nothing outside the plan is touched.
    [[nodiscard]] bool only_plan() const;
};

/// For each line that misses its goal: the measures that reach it, the cheapest first, at most one of each
/// kind; pairs of kinds where no single one does; nothing where none was found. The goal of a line is what it
/// misses first: `sound`, with faults where the project wrote them, with a dead device where `dead_device`.
/// Every figure is of the changed project. Bounded: about 200 plans, fewer for large projects.
[[nodiscard]] std::vector<Measure> measures(const model::Project& project,
                                            const std::vector<LineGuarantee>& guarantees,
                                            bool dead_device = false);

}  // namespace takt::plan
