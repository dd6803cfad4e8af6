// Tables that are pasted: of an IDE, a spreadsheet, a CSV file.
#pragma once

#include "takt/web/api.hpp"

namespace takt::web {

/// POST /import: {"text"} to {"kind", "rows": [{key: text}], "findings"}.
[[nodiscard]] ApiResponse import_table(const ApiRequest& request);

}  // namespace takt::web
