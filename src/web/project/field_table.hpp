// The field table of module model as JSON.
#pragma once

#include "takt/web/api.hpp"

namespace takt::web {

/// GET /fields?profile=&transport=&framing=: {"objects": {"device": {"poll_period": {"kind", "required",
/// "least", "greatest", "tolerated", "unit", "words", "allowed", "default"}}}}. Durations are in nanoseconds.
[[nodiscard]] ApiResponse field_table(const ApiRequest& request);

}  // namespace takt::web
