// Reads CSV tables of variables into nodes.
#pragma once

#include <cstddef>
#include <string>

#include "takt/file/table.hpp"
#include "takt/model/document.hpp"
#include "yaml/reporter.hpp"
#include "yaml/source.hpp"

namespace takt::file {

/// A table as read.
struct Contents {
    model::Node rows;
    TableKind kind = TableKind::variables;
};

/// Reads a table as a list of mappings, one per row. Keys are those of a variable, located at their heading.
/// Values are in the words of the project file. An empty cell gives no key; a row of empty cells gives no
/// mapping. Damaged rows are reported and omitted. Each unknown column is reported once; its cells are
/// appended to the comments. Every node reduces `nodes_left`.
///
/// Node::quoted only states that the cell is quoted. Spreadsheets quote at will, so a quoted cell may
/// be a number and an unquoted one text.
Contents read_csv(const Source& source, const TableOptions& options, std::size_t& nodes_left,
                  Reporter& reporter);

/// The same from the bytes of a file in any supported encoding; `file` is its index in the document.
Contents read_csv_bytes(std::uint32_t file, const std::string& bytes, const TableOptions& options,
                        std::size_t& nodes_left, Reporter& reporter);

}  // namespace takt::file
