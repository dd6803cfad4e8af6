// Measures that make an infeasible line feasible (docs/guarantees.md, "Measures"). Each one is a changed
// project that is planned and proved again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "takt/plan/guarantee.hpp"

namespace takt::plan {

enum class MeasureKind : std::uint8_t {
    grouping,
    turnarounds,  ///< a limit for those that are not known; the devices must keep it
    time_outs,
    splitting,
    relay_interval,  ///< fewer relayed requests go ahead of polling
    bit_rate,
    periods,
    attempts
};
[[nodiscard]] std::string_view name(MeasureKind kind);

/// The goal of a measure: nothing is late without failures, under the project's faults, or with the worst
/// dead device. Each goal includes the previous ones.
enum class Goal : std::uint8_t { sound, with_faults, with_dead_device };

/// A change of one key of the project file.
struct Change {
    std::string path;  ///< of its object: "lines[0].devices[2]"; empty: the project itself
    std::string name;  ///< of its object
    std::string key;
    std::string from;  ///< as in a project file; empty: the key was not set
    std::string to;
};

struct Measure {
    std::vector<MeasureKind> kinds;  ///< one or two
    /// A longer period of the request, or the requests, with the largest share of the line: that share.
    double largest_share = 0;
    std::size_t line = 0;
    Goal goal = Goal::sound;
    std::vector<Change> changes;
    std::function<void(model::Project&)> apply;  ///< makes these changes in the project
    /// The variable that was latest, with its responses before and after (of the kind of the goal).
    std::string variable;
    std::optional<Duration> before;
    std::optional<Duration> after;
    Duration deadline{};  ///< that is now met
    double utilization_before = 0;
    double utilization_after = 0;

    /// Time-outs, splitting, grouping: changes that concern only the plan.
    [[nodiscard]] bool only_plan() const;
};

/// The result of a search for measures.
struct MeasureSearch {
    std::vector<Measure> found;           ///< ascending by line
    std::vector<std::size_t> unfinished;  ///< lines whose search ended at its limit, ascending
};

/// For each line that misses its goal: the measures that reach it, at most one of each kind, what helps most
/// first (docs/guarantees.md, "Measures"); pairs of kinds if no single kind suffices; nothing if none was
/// found. The goal of a line is the first one that it misses: `sound`, with faults if the project sets them,
/// with a dead device if `dead_device`. All figures are those of the changed project. The search is bounded:
/// about 200 plans for a line, about 400,000 planned variables for the project, in any number of lines, and a
/// limit of the proofs' work (Effort). The lines share these limits equally.
/// @param plan         of that project
/// @param guarantees   of guarantee(project, plan)
/// @param dead_device  a line that only misses the goal with_dead_device is searched too
/// @param progress     lines searched, and lines in all; after each trial plan and each line
[[nodiscard]] MeasureSearch measures(const model::Project& project, const Plan& plan,
                                     const std::vector<LineGuarantee>& guarantees, bool dead_device = false,
                                     const Progress& progress = {});

/// The measures of one line.
/// @param measures  ascending by line
[[nodiscard]] std::span<const Measure> measures_of(std::span<const Measure> measures, std::size_t line);

}  // namespace takt::plan
