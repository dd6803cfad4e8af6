// Values as JSON.
#pragma once

#include "takt/base/data_type.hpp"
#include "takt/file/json.hpp"
#include "takt/value/value.hpp"

namespace takt::host {

/// A number, a text, true, false, or null where there is no value. An unscaled `float` has the shortest
/// decimal number that is this float; numbers that are not finite are null when they are written.
[[nodiscard]] file::Json to_json(DataType type, bool scaled, const value::Value& value);

}  // namespace takt::host
