// A request table as tables of text and as JSON (docs/formats/request-table.md).
#pragma once

#include <string>

#include "takt/file/json.hpp"
#include "takt/report/drawing/texts.hpp"
#include "takt/table/owen.hpp"
#include "takt/table/view.hpp"

namespace takt::report {

[[nodiscard]] std::string table_text(const Texts& texts, const table::View& view);
[[nodiscard]] file::Json table_json(const table::View& view);

/// A table in the format of the OWEN KC1.
/// @param image  the bytes that `table` was read from
[[nodiscard]] std::string table_text(const Texts& texts, const table::OwenTable& table, Bytes image);
[[nodiscard]] file::Json table_json(const table::OwenTable& table, Bytes image);

/// Why a file is refused as a request table, and on a second line, where there is one, what to do about it.
/// @param error  of table::View::open() or table::read_owen()
[[nodiscard]] std::string table_error_text(const Texts& texts, const std::string& path, const Error& error);

}  // namespace takt::report
