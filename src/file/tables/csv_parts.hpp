// Divides a text into the windows and tables that it consists of.
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "tables/csv_rows.hpp"
#include "yaml/reporter.hpp"
#include "yaml/source.hpp"

namespace takt::file {

/// A table with its line of headings, or the fields of one device or variable as a window shows them: a name
/// and a value in each line.
struct Part {
    bool window = false;
    char separator = ',';
    Row names;              ///< headings, or the fields of a window
    Row values = {};        ///< of a window
    std::size_t begin = 0;  ///< of a table: offset of its first row
    std::size_t end = 0;
};

/// The parts of a text in their order. Lines of an IDE's tree (`RS485, Слот 1, Master`) are skipped; its line
/// `Устройство, 16` gives name and address of the window or table below. Lines that belong to no part are
/// reported, and there are no parts then.
/// @param separator  of cells; 0: detected
std::vector<Part> divide(const Source& source, char separator, Reporter& reporter);

}  // namespace takt::file
