// Request tables in files.
#pragma once

#include <optional>
#include <string>

#include "takt/app/texts.hpp"
#include "takt/table/build.hpp"
#include "takt/table/view.hpp"

namespace takt::app {

/// The bytes of a table, and which of the two formats they claim to be.
struct TableFile {
    table::Image image;
    bool owen = false;
};

/// Reads a file that should be a table. An unreadable one is reported on stderr, and nothing is returned.
[[nodiscard]] std::optional<TableFile> read_table_file(const Texts& texts, const std::string& path);

/// Writes a temporary file beside `path` and renames it, so that a reader of `path` sees the old table or
/// the new one.
/// @returns cannot_open, io_failed (path, errno)
[[nodiscard]] Result<void> write_table_file(const std::string& path, const table::Image& image);

}  // namespace takt::app
