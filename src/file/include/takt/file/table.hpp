// Tables of variables as CSV: read in the words of a spreadsheet or of an IDE, and written again.
//
// A table's first line names its columns, in any order: by the keys of a variable (model's field table) or by
// their headings in English, Russian or Ukrainian; capital letters, spaces, punctuation and apostrophes do
// not count, and a heading may end in a unit (`Период, мс`). Cells may hold words of those languages where
// the project file has its own (`Логический`, `Да`, `03 (0x03) Read Holding Registers`, `10h`); what is read
// is always in the words of the project file. docs/project-file.md describes it for users.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/file/load.hpp"
#include "takt/model/document.hpp"
#include "takt/model/findings.hpp"

namespace takt::file {

enum class Encoding : std::uint8_t { utf8, cp1251 };

/// What a number in the column of register addresses is.
enum class Addresses : std::uint8_t {
    zero_based,  ///< as on the wire; a warning where all of them look like references
    reference,   ///< the one-based notation: 40108 is holding register 107
    automatic,   ///< references where all numbers of the table can only be meant so, with a warning
};

/// Columns of a table of several devices, beside those of a variable.
inline constexpr std::string_view kLineColumn = "line";
inline constexpr std::string_view kDeviceColumn = "device";
inline constexpr std::string_view kUnitAddressColumn = "unit_address";

struct TableOptions {
    std::optional<Encoding> encoding;  ///< nothing: found by itself
    char separator = 0;                ///< `,`, `;` or a tab; 0: found by itself
    Addresses addresses = Addresses::zero_based;
    bool devices = false;  ///< kLineColumn, kDeviceColumn and kUnitAddressColumn may be there
};

/// A table by itself: the root of its document is a list of mappings, one a row, with the keys of a project
/// file; files[1] is the table (files[0] has no name: there is no project).
[[nodiscard]] Loaded load_table(const std::string& path, const TableOptions& options = {});

/// The same from bytes.
[[nodiscard]] Loaded load_table_text(const std::string& name, const std::string& bytes,
                                     const TableOptions& options = {});

/// Languages of the first line; `keys`: the keys of the project file.
enum class Headings : std::uint8_t { keys, english, russian, ukrainian };

struct TableFormat {
    Headings headings = Headings::keys;
    char separator = ',';  ///< `,`, `;` or a tab
    Encoding encoding = Encoding::utf8;
    bool byte_order_mark = false;  ///< in front of UTF-8: some spreadsheets know it by nothing else
};

struct Written {
    std::string bytes;                     ///< empty when there are findings
    std::vector<model::Finding> findings;  ///< errors: what the format cannot hold, at its location
};

/// Writes rows (mappings of scalars, as load_table() gives them or a project file has them) as RFC 4180 has
/// it, lines ended by CR LF. Columns: those that the IDE's table has, then the others that a row has. Reading
/// it gives the same rows; what would not come back is refused.
[[nodiscard]] Written write_table(const std::vector<model::Node>& rows, const TableFormat& format);

/// The heading of a column; the key itself where the language has none.
[[nodiscard]] std::string_view heading(std::string_view key, Headings headings);

/// Whether a key has a heading in every language.
[[nodiscard]] bool has_headings(std::string_view key);

}  // namespace takt::file
