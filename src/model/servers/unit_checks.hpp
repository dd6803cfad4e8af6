// Checks for contradictions in a unit of a server.
#pragma once

#include <string>
#include <vector>

#include "servers/interpretation.hpp"

namespace takt::model {

/// "0..9, 20..20"
[[nodiscard]] std::string to_text(const std::vector<ItemRange>& ranges);

/// Checks overlays and limits of missing items, limits that allow no value, and retained items that are never
/// written.
void check_banks(Interpretation& state, const ServerUnit& unit, const std::string& path);

/// Checks the last variable of the unit: location, default value, and duplicate bindings of its items.
/// @param node  of the variable
void check_served_variable(Interpretation& state, const ServerUnit& unit, const Node& node,
                           const std::string& path);

/// Warns of used variables that share items. A bit of a register may lie in a variable of that register.
/// To be called when all variables of the unit are read.
void check_overlaps(Interpretation& state, const ServerUnit& unit, const std::string& path);

}  // namespace takt::model
