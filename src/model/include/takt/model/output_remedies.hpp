// What helps an output whose broker does not acknowledge its messages fast enough.
#pragma once

#include <optional>
#include <string>

#include "takt/model/output.hpp"

namespace takt::model {

/// The remedies that the settings of an output with transport mqtt leave open: words separated by commas, the
/// texts `output.remedy.WORD`. At least one.
/// @param needed  messages in flight that suffice; nothing: unknown
[[nodiscard]] std::string output_remedies(const Output& output, std::optional<double> needed = {});

}  // namespace takt::model
