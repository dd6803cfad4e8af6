// Translates the words of tables into those of project files.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "takt/file/table.hpp"
#include "takt/model/document.hpp"
#include "yaml/reporter.hpp"

namespace takt::file {

/// A column as its heading describes it.
struct Column {
    model::Node key;      ///< its text: the key
    std::string heading;  ///< as written
    bool kept = false;    ///< known, and the first one of that key
    std::string unit;     ///< unit of durations without one
    bool hexadecimal = false;
    bool noted = false;  ///< unknown: its cells become comments
};

/// What the columns of a table give.
struct TableShape {
    bool unaddressed = false;  ///< neither functions nor areas
    bool functions = false;    ///< read and write functions
};

/// Translates a cell. Unknown text stays, so that the finding about it shows the original.
/// @returns whether the cell has a value: a dash in a numeric column has none
bool settle_cell(const Column& column, model::Node& cell, bool decimal_comma);

/// Translates cells that depend on others: the default value on the type, the type on the number of
/// registers.
void settle_row(model::Node& row, bool decimal_comma, Reporter& reporter);

/// Decides whether the numbers in `register` are addresses or references, and renames the references.
/// References are in the standard notation then. Rows whose reference is none are reported and removed.
/// Rows without area in a table without functions, and rows without traffic, are coils if they are bools,
/// else holding registers.
void settle_addresses(model::Node& list, const TableOptions& options, TableShape shape, Reporter& reporter);

/// A text as a comment: in one line, and not longer than a comment may be; and the rest of it.
std::pair<std::string, std::string> as_comment(std::string_view text);

/// Whether another reader of tables would take a register number for a reference.
bool looks_like_reference(std::string_view text);

}  // namespace takt::file
