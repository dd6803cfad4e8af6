// gaps: learn. What of a plan was never tried, and the plan that does without it (docs/guarantees.md,
// docs/planning.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "takt/plan/plan.hpp"

namespace takt::plan {

/// Items side by side that no variable of the function uses, and what has to be read with them.
struct Gap {
    model::ItemRange items;
    std::uint16_t before = 0;  ///< first item of the value that ends where the gap begins
    std::uint16_t after = 0;   ///< last item of the value that begins where the gap ends
    friend bool operator==(const Gap&, const Gap&) = default;
};

/// Gaps of one device that one read of the plan would bridge, ascending: to be tried.
/// From `before` of any of them to `after` of any later one a read is within all limits.
struct Trial {
    std::size_t device = 0;
    wire::Function read = wire::Function::read_holding_registers;
    std::vector<Gap> gaps;  ///< not empty
    bool refused = false;   ///< one gap, which the device refused: to be asked for again at long intervals
    friend bool operator==(const Trial&, const Trial&) = default;
};

/// What a line that learns is to do: a plan that reads confirmed gaps only, and what is to be tried.
struct LearningPlan {
    LinePlan plan;
    std::vector<Trial> trials;  ///< by device, function, first gap; each gap in one of them
};

/// Whether a device of the line tries gaps: gaps: learn, in strategy optimal.
[[nodiscard]] bool learns(const model::Line& line);
[[nodiscard]] bool learns(const model::Device& device);

/// The same project with every device that learns bound to what is confirmed of it. Its plan is the one that
/// is proved.
[[nodiscard]] model::Project confirmed_only(const model::Project& project);

/// A read that bridges gaps is longer than those it replaces, and what is more urgent waits for it: where
/// that makes a deadline miss that the plan without what was learnt holds, that plan stays.
/// @param learnt  of each device of the line, instead of what stands in the project; empty: that
[[nodiscard]] LearningPlan learning_plan(const model::Project& project, std::size_t line,
                                         const std::vector<model::Learnt>& learnt = {});

/// The items of a range of one area that no variable reads with that function.
[[nodiscard]] std::vector<model::ItemRange> gaps_in(const model::Device& device, wire::Function read,
                                                    const model::ItemRange& range);

/// The area a read function reads.
[[nodiscard]] wire::Area area_of(wire::Function read);

}  // namespace takt::plan
