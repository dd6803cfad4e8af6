// What contradicts itself in a unit of a server.
#pragma once

#include <string>
#include <vector>

#include "interpretation.hpp"

namespace takt::model {

/// "0..9, 20..20"
[[nodiscard]] std::string to_text(const std::vector<ItemRange>& ranges);

/// Overlays and limits of what is not there, limits that leave no value, what is retained and never written.
void check_banks(Interpretation& state, const ServerUnit& unit, const std::string& path);

/// The last variable of the unit: its location, its default value, and who else gives its items a value.
/// @param node  of the variable
void check_served_variable(Interpretation& state, const ServerUnit& unit, const Node& node,
                           const std::string& path);

}  // namespace takt::model
