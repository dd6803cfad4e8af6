// The byte orders of a project as permutations (takt/model/byte_order.hpp).
#pragma once

#include <string>

#include "takt/file/json.hpp"
#include "takt/model/project.hpp"

namespace takt::report {

/// "2143", with as many digits as the value has bytes; null for a coil or a discrete input.
[[nodiscard]] file::Json byte_order_json(const model::Variable& variable);

/// The devices of all lines: line, name, unit, byte_order, and the variables with another order.
[[nodiscard]] file::Json byte_orders_json(const model::Project& project);

/// "Boiler 4321 (T1 2143), Meter 1234": devices and variables whose order is not 2143; empty if there are
/// none. Long lists are cut.
[[nodiscard]] std::string byte_orders_text(const model::Line& line);

/// The names of the orders in that text: "1234 = DCBA, 4321 = ABCD".
[[nodiscard]] std::string byte_order_names(const model::Line& line);

}  // namespace takt::report
