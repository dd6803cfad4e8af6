// The values of a running project as a table.
#pragma once

#include <string>
#include <vector>

#include "takt/host/snapshot.hpp"
#include "takt/report/panel.hpp"
#include "takt/report/texts.hpp"

namespace takt::report {

/// A heading and a row for each value, with its age and what is wrong with it. The lines fit the screen: rows
/// beyond it are left out and counted in a last line.
/// @param snapshot  with values
[[nodiscard]] std::vector<std::string> values_table(const Texts& texts, const host::Snapshot& snapshot,
                                                    const Screen& screen);

}  // namespace takt::report
