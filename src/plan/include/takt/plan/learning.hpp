// gaps: learn. The plan without untried gaps, and the trial reads for them (docs/planning.md, "Learning
// gaps").
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "takt/plan/plan.hpp"

namespace takt::plan {

/// Consecutive items that no variable of the function uses, with their neighbouring values.
struct Gap {
    model::ItemRange items;
    std::uint16_t before = 0;  ///< first item of the value that ends where the gap begins
    std::uint16_t after = 0;   ///< last item of the value that begins where the gap ends
    friend bool operator==(const Gap&, const Gap&) = default;
};

/// Untried gaps of one device that one read of the plan would bridge, ascending. Each read from `before` of
/// one gap to `after` of the same or a later one is within all limits.
struct Trial {
    std::size_t device = 0;
    wire::Function read = wire::Function::read_holding_registers;
    std::vector<Gap> gaps;  ///< not empty
    bool refused = false;   ///< a single gap that the device refused; retried at long intervals
    friend bool operator==(const Trial&, const Trial&) = default;
};

/// The work of a learning line: a plan that reads only confirmed gaps, and the trials.
struct LearningPlan {
    LinePlan plan;
    std::vector<Trial> trials;  ///< by device, function, first gap; each gap in one of them
};

/// Whether a device, or any device of a line or a project, tries gaps: gaps: learn, in strategy optimal.
[[nodiscard]] bool learns(const model::Project& project);
[[nodiscard]] bool learns(const model::Line& line);
[[nodiscard]] bool learns(const model::Device& device);

/// The project, or the line, with each learning device restricted to its confirmed gaps. Its plan is the
/// proved one.
[[nodiscard]] model::Project confirmed_only(const model::Project& project);
[[nodiscard]] model::Line confirmed_only(model::Line line);

/// The same, with the time-outs that were derived from measured response times written (turnaround: learn):
/// for a controller, which does not learn.
[[nodiscard]] model::Project without_learning(const model::Project& project);

/// A read that bridges gaps is longer than those it replaces, and more urgent requests wait for it. If it
/// makes a deadline miss that the plan without the new results meets, that plan stays. A plan made with new
/// results has its proved refresh bounds.
/// @param learnt  of each device of the line, instead of the project's; empty: the project's
[[nodiscard]] LearningPlan learning_plan(const model::Project& project, std::size_t line,
                                         const std::vector<model::Learnt>& learnt = {});

/// The items of a range that no variable reads with that function.
[[nodiscard]] std::vector<model::ItemRange> gaps_in(const model::Device& device, wire::Function read,
                                                    const model::ItemRange& range);

}  // namespace takt::plan
