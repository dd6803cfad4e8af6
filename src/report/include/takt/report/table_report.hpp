// A request table, told: as tables for people, and as JSON (docs/formats/request-table.md).
#pragma once

#include <string>

#include "takt/file/json.hpp"
#include "takt/report/texts.hpp"
#include "takt/table/owen.hpp"
#include "takt/table/view.hpp"

namespace takt::report {

[[nodiscard]] std::string table_text(const Texts& texts, const table::View& view);
[[nodiscard]] file::Json table_json(const table::View& view);

/// @param image  the bytes `table` was read from
[[nodiscard]] std::string table_text(const Texts& texts, const table::OwenTable& table, Bytes image);
[[nodiscard]] file::Json table_json(const table::OwenTable& table, Bytes image);

}  // namespace takt::report
