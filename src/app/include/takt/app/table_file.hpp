// A request table as a file: read, told what is wrong with it, written whole or not at all.
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

/// Reads a file that is to be a table; complains and answers nothing where it cannot be read.
[[nodiscard]] std::optional<TableFile> read_table_file(const Texts& texts, const std::string& path);

/// Says on stderr why a table is refused.
void complain_about_table(const Texts& texts, const std::string& path, const Error& error);

/// Writes beside `path` and renames: whoever reads `path` sees the old table or the new one.
/// @returns cannot_open, io_failed (path, operating system's number)
[[nodiscard]] Result<void> write_table_file(const std::string& path, const table::Image& image);

}  // namespace takt::app
