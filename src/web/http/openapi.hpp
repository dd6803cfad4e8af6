// docs/openapi.json, compiled in.
#pragma once

#include <string_view>

namespace takt::web {

[[nodiscard]] std::string_view openapi_text();

}  // namespace takt::web
