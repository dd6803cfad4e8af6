// A table of variables to nodes.
#pragma once

#include <cstddef>

#include "reporter.hpp"
#include "source.hpp"
#include "takt/model/document.hpp"

namespace takt::file {

/// Reads a table (RFC 4180, or with semicolons) as a list of mappings, one a row: the keys are the names in
/// the first line (with their place there), an empty cell is a key that is not there, a row of empty cells is
/// none. Rows that are damaged are left out and reported. Each node is taken from `nodes_left`.
///
/// Node::quoted tells that a cell stands in quotes, no more: spreadsheets put them where they please, so that
/// a cell in quotes may be a number and one without may be text.
model::Node read_csv(const Source& source, std::size_t& nodes_left, Reporter& reporter);

}  // namespace takt::file
