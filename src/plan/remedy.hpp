// The single steps of the measures: a project with one setting changed, from the mildest step on.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "takt/plan/measures.hpp"

namespace takt::plan {

/// A project and what was changed on the way to it.
struct Variant {
    model::Project project;
    std::vector<Change> changes;
};

/// Makes a variant when it is asked for; nothing where it would change nothing.
using Step = std::function<std::optional<Variant>()>;

/// All steps of one kind on one line, the mildest first: each goes further than the one before.
/// @param from  must outlive the steps
[[nodiscard]] std::vector<Step> steps(MeasureKind kind, const Variant& from, std::size_t line);

}  // namespace takt::plan
