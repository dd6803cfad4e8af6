// The steps of the measures: projects with one changed setting, mildest step first.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "takt/plan/measures.hpp"

namespace takt::plan {

/// A project with its changes.
struct Variant {
    model::Project project;
    std::vector<Change> changes;
};

/// Makes a variant on demand; nothing if it would change nothing.
using Step = std::function<std::optional<Variant>()>;

/// The steps of one kind on one line, mildest first; each goes further than the previous one.
/// @param from  must outlive the steps
[[nodiscard]] std::vector<Step> steps(MeasureKind kind, const Variant& from, std::size_t line);

}  // namespace takt::plan
