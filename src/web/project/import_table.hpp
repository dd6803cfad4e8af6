// Tables that are pasted: of an IDE, a spreadsheet, a CSV file.
#pragma once

#include "takt/web/api.hpp"

namespace takt::web {

/// POST /import: {"text"} to {"kind", "rows": [{key: text}], "findings"}. The findings and the names of the
/// variables are those of `takt convert`. "profile", "transport", "device" and "names" describe the project
/// that the rows are for (docs/openapi.json). Or {"keys", "cells"}, rows without headings, to {"rows"}; a row
/// with the empty choice of an IDE is null.
[[nodiscard]] ApiResponse import_table(const ApiRequest& request);

}  // namespace takt::web
