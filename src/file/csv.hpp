// A table of variables to nodes: the one reader of tables.
#pragma once

#include <cstddef>
#include <string>

#include "reporter.hpp"
#include "source.hpp"
#include "takt/file/table.hpp"
#include "takt/model/document.hpp"

namespace takt::file {

/// Reads a table as a list of mappings, one a row: the keys are those of a variable (with the location of
/// their heading), the values in the words of the project file; an empty cell is a key that is not there, a
/// row of empty cells is none. Rows that are damaged and columns that are not known are left out and
/// reported, the latter once. Each node is taken from `nodes_left`.
///
/// Node::quoted tells that a cell stands in quotes, no more: spreadsheets put them where they please, so that
/// a cell in quotes may be a number and one without may be text.
model::Node read_csv(const Source& source, const TableOptions& options, std::size_t& nodes_left,
                     Reporter& reporter);

/// The same from the bytes of a file, in whatever encoding they are; `file` is its index in the document.
model::Node read_csv_bytes(std::uint32_t file, const std::string& bytes, const TableOptions& options,
                           std::size_t& nodes_left, Reporter& reporter);

}  // namespace takt::file
