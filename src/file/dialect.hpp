// From the words of a table to those of a project file.
#pragma once

#include <string>
#include <vector>

#include "reporter.hpp"
#include "takt/file/table.hpp"
#include "takt/model/document.hpp"

namespace takt::file {

/// What the first line says about a column.
struct Column {
    model::Node key;    ///< its text: the key
    bool kept = false;  ///< known, and the first one of that key
    std::string unit;   ///< of bare durations
    bool hexadecimal = false;
};

/// Puts a cell in the words of the project file; what it does not know it leaves, so that the finding about
/// it shows what stands there.
/// @returns whether the cell says anything: a dash in the column of a number does not
bool settle_cell(const Column& column, model::Node& cell, bool decimal_comma);

/// What depends on other cells of the row: the default value on the type, the type on the count of registers.
void settle_row(model::Node& row, bool decimal_comma, Reporter& reporter);

/// Decides what the numbers in `register` are, and makes `reference` of them where they are references.
void settle_addresses(model::Node& list, Addresses addresses, Reporter& reporter);

/// Whether another table reader would take a register's number for a reference.
bool looks_like_reference(std::string_view text);

}  // namespace takt::file
