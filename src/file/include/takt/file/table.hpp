// CSV tables of variables: reading and writing, in the words of a spreadsheet or an IDE.
//
// A table's first line names its columns, in any order: by the keys of a variable (model's field table) or by
// their headings in English, Russian or Ukrainian; capital letters, spaces, punctuation and apostrophes do
// not count, and a heading may end in a unit (`Период, мс`). Cells may hold words of those languages where
// the project file has its own (`Логический`, `Да`, `03 (0x03) Read Holding Registers`, `10h`); what is read
// is always in the words of the project file. docs/project-file.md describes it for users.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "takt/file/load.hpp"
#include "takt/model/document.hpp"
#include "takt/model/findings.hpp"

namespace takt::file {

enum class Encoding : std::uint8_t { utf8, cp1251 };

/// The meaning of the numbers in the register column.
enum class Addresses : std::uint8_t {
    zero_based,  ///< as on the wire; the interpretation warns of those that look like references
    reference,   ///< the one-based notation: 40108 is holding register 107
    automatic,   ///< references where all numbers of the table can only be meant so, with a warning
};

/// The numbering of the classic notation in a table.
enum class Notation : std::uint8_t {
    standard,        ///< from one; coils at 00001
    coils_at_20001,  ///< from one; coils at 20001
    zero_based,      ///< from zero: 40000 is holding register 0; coils at 00000 or 20000
};

/// Additional columns of a table of several devices.
inline constexpr std::string_view kLineColumn = "line";
inline constexpr std::string_view kTargetColumn = "target";  ///< connection of the line: tcp://10.0.0.5
inline constexpr std::string_view kDeviceColumn = "device";
inline constexpr std::string_view kUnitAddressColumn = "unit_address";
/// Columns of settings of a device: keys of a device, and the protocol of its line as an IDE names it.
inline constexpr std::string_view kProtocolColumn = "protocol";
inline constexpr std::array<std::string_view, 6> kDeviceSettings{"response_timeout", "attempts",
                                                                 "poll_enable",      kProtocolColumn,
                                                                 "group_requests",   "registers_per_request"};

/// What a table lists. The columns decide.
enum class TableKind : std::uint8_t {
    variables,  ///< of a device, with functions or areas
    locals,     ///< of the project: no address, but retention, a default or use
    served,     ///< of a server: addresses and use, no functions
    list,       ///< of a device: addresses only
    devices,    ///< of a project: settings of devices, no variables
};

struct TableOptions {
    std::optional<Encoding> encoding;  ///< nothing: detected
    char separator = 0;                ///< `,`, `;` or a tab; 0: detected
    Addresses addresses = Addresses::zero_based;
    Notation notation = Notation::standard;  ///< another one: all numbers are references in it
    bool strict = false;   ///< an unknown column is an error; else a warning, its cells become comments
    bool devices = false;  ///< kLineColumn .. kUnitAddressColumn and kDeviceSettings may be there
};

/// A table without project. The root of the document is a list of mappings, one per row, with the keys of a
/// project file. files[1] is the table; files[0] has no name.
[[nodiscard]] Loaded load_table_text(const std::string& name, const std::string& bytes,
                                     const TableOptions& options = {});

/// A row of cells without a heading line, under keys of a variable or a device: in the words of a project
/// file, without the cells that give no value. Numbers may have decimal commas; a duration without a unit is
/// in milliseconds. Nothing: the row is the empty choice of an IDE.
[[nodiscard]] std::optional<model::Node> read_row(std::span<const std::pair<std::string, std::string>> cells);

/// Several tables. `loaded` has no root; its files[1] is the first table.
struct LoadedTables {
    struct Table {
        model::Node rows;
        TableKind kind = TableKind::variables;
    };
    Loaded loaded;  ///< readable if all tables are
    std::vector<Table> tables;
};
[[nodiscard]] LoadedTables load_tables(const std::vector<std::string>& paths,
                                       const TableOptions& options = {});
/// The same from bytes: name and contents of each.
[[nodiscard]] LoadedTables load_tables_text(const std::vector<std::pair<std::string, std::string>>& texts,
                                            const TableOptions& options = {});

/// Language of the headings; `keys`: the keys of the project file; `ide`: headings and cells in the words of
/// the IDE that the tables of docs/ide-tables.md come from.
enum class Headings : std::uint8_t { keys, english, russian, ukrainian, ide };

struct TableFormat {
    Headings headings = Headings::keys;
    TableKind kind = TableKind::variables;
    char separator = ',';  ///< `,`, `;` or a tab
    Encoding encoding = Encoding::utf8;
    bool byte_order_mark = false;  ///< for UTF-8: some spreadsheets need it to detect the encoding
};

struct Written {
    std::string bytes;                     ///< empty when there are findings
    std::vector<model::Finding> findings;  ///< errors: what the format cannot hold, at its location
};

/// Writes rows (mappings of scalars, as from load_table_text() or a project file) according to RFC 4180,
/// lines ended by CR LF. Columns: those of the IDE's table, then any others in use. Reading the result gives
/// the same rows; values that would not come back are findings.
[[nodiscard]] Written write_table(const std::vector<model::Node>& rows, const TableFormat& format);

/// The heading of a column; the key itself if the language has no heading for it.
[[nodiscard]] std::string_view heading(std::string_view key, Headings headings);

/// Whether a key has a heading in every language.
[[nodiscard]] bool has_headings(std::string_view key);

}  // namespace takt::file
