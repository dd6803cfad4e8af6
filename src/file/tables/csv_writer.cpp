// Writes CSV tables. Every cell is checked with the reader itself, so that reading the table back gives the
// same values.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>

#include "tables/dialect.hpp"
#include "tables/encoding.hpp"
#include "tables/headings.hpp"
#include "takt/file/table.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/scalar.hpp"
#include "yaml/reporter.hpp"

namespace takt::file {
namespace {

using model::Node;

constexpr std::array kPlaceColumns{kLineColumn, kTargetColumn, kDeviceColumn, kUnitAddressColumn};
constexpr std::array<std::string_view, 7> kIdeColumns{"name",     "type", "read",   "write",
                                                      "register", "bit",  "comment"};
constexpr std::string_view kLineEnd = "\r\n";

std::string_view name_of(Encoding encoding) {
    return encoding == Encoding::utf8 ? "UTF-8" : "CP1251";
}

bool has_value(const Node& row, std::string_view key) {
    const auto* const cell = row.find(key);
    return cell != nullptr && cell->kind == Node::Kind::scalar;
}

std::string_view cell_of(const Node& row, std::string_view key) {
    return has_value(row, key) ? std::string_view(row.find(key)->text) : std::string_view();
}

// Whether a table with addresses alone is read with the area of this row.
bool has_assumed_area(const Node& row) {
    if (!has_value(row, "register")) return false;
    const bool bit = cell_of(row, "type") == "bool";
    const auto area = cell_of(row, "area");
    if (!area.empty()) return area == (bit ? "coil" : "holding_register");
    const auto read = model::parse_integer(cell_of(row, "read"));
    return read && read->magnitude == (bit ? 1U : 3U);
}

std::span<const std::string_view> ide_columns(TableKind kind) {
    static constexpr std::array<std::string_view, 6> kLocals{"name",    "type", "retain",
                                                             "default", "used", "comment"};
    static constexpr std::array<std::string_view, 5> kServed{"name", "type", "register", "used", "comment"};
    static constexpr std::array<std::string_view, 4> kList{"name", "type", "register", "comment"};
    static constexpr std::array<std::string_view, 2> kDevices{"name", "register"};
    switch (kind) {
        case TableKind::locals: return kLocals;
        case TableKind::served: return kServed;
        case TableKind::list: return kList;
        case TableKind::devices: return kDevices;
        case TableKind::variables: break;
    }
    return kIdeColumns;
}

bool is_double_word(const Node& row) {
    return has_value(row, "type") && row.find("type")->text == "int32";
}

// The area in which a row is read or written if it names no area.
std::string_view area_of(const Node& row) {
    const auto area = cell_of(row, "area");
    if (!area.empty()) return area;
    const auto reference = cell_of(row, "reference");
    if (reference.starts_with('0')) return "coil";
    if (reference.starts_with('1')) return "discrete_input";
    if (reference.starts_with('3')) return "input_register";
    if (reference.starts_with('4')) return "holding_register";
    return has_value(row, "coil") ? "coil" : "";
}

// The function of a row as the project has it. Without both functions the area is read.
std::string_view function_of(const Node& row, std::string_view key) {
    if (has_value(row, key)) return cell_of(row, key);
    if (key == "write" || has_value(row, "write")) return "none";
    const auto* const area = std::ranges::find(model::kAreas, area_of(row));
    constexpr std::array<std::string_view, 4> kReads{"0x01", "0x02", "0x04", "0x03"};
    static_assert(model::kAreas[2] == "input_register" && model::kAreas[3] == "holding_register");
    return area == model::kAreas.end() ? "" : kReads[static_cast<std::size_t>(area - model::kAreas.begin())];
}

// Whether a row with its functions written out needs no area.
bool functions_give_area(const Node& row) {
    const auto has_function = [&](std::string_view key) {
        const auto function = function_of(row, key);
        return !function.empty() && function != "none";
    };
    return has_function("read") || has_function("write");
}

std::vector<std::string_view> columns_of(const std::vector<Node>& rows, const TableFormat& format) {
    const auto ide = ide_columns(format.kind);
    const auto unknown_area = [](const Node& row) {
        return has_value(row, "register") && !has_value(row, "area") && !has_value(row, "read") &&
               !has_value(row, "write");
    };
    const bool unaddressed = format.kind == TableKind::served || format.kind == TableKind::list;
    const auto used = [&](std::string_view key) {
        return std::ranges::any_of(rows, [&](const Node& row) { return has_value(row, key); });
    };
    std::vector<std::string_view> columns;
    for (const auto key : kPlaceColumns)
        if (used(key)) columns.push_back(key);
    for (const auto key : kDeviceSettings)
        if (used(key)) columns.push_back(key);
    columns.insert(columns.end(), ide.begin(), ide.end());
    // Below columns of both functions empty cells say that the variable has no traffic.
    if (format.headings != Headings::ide && std::ranges::any_of(rows, unknown_area))
        for (const std::string_view key : {"read", "write"})
            if (!used(key)) {
                std::erase(columns, key);
                break;
            }
    if (format.headings == Headings::ide && std::ranges::any_of(rows, is_double_word))
        columns.push_back(kRegistersColumn);
    // With use but without functions a list would be the table of a server.
    const bool like_served = format.kind == TableKind::list && used("used");
    if (like_served) columns.push_back("read");
    // The area of such a table is assumed; only another one is written.
    const bool assumed = unaddressed && !like_served && std::ranges::all_of(rows, has_assumed_area);
    const bool given = format.headings == Headings::ide && format.kind == TableKind::variables &&
                       std::ranges::all_of(rows, functions_give_area);
    for (const auto& field : model::fields(model::Object::variable)) {
        if (std::ranges::find(columns, field.key) != columns.end() || !used(field.key)) continue;
        if (given && field.key == "area") continue;
        if (!assumed || (field.key != "area" && field.key != "read" && field.key != "write"))
            columns.push_back(field.key);
    }
    return columns;
}

std::string quoted_cell(std::string_view text) {
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"') result += '"';
        result += c;
    }
    return result + '"';
}

class CsvWriter {
public:
    explicit CsvWriter(const TableFormat& format) : format_(format) {}

    Written write(const std::vector<Node>& rows) {
        const auto columns = columns_of(rows, format_);
        for (std::size_t i = 0; i < columns.size(); ++i) put(i, std::string(heading_of(columns[i])));
        text_ += kLineEnd;
        for (const auto& row : rows) write_row(row, columns);
        Written written;
        if (auto bytes = encoded()) written.bytes = *std::move(bytes);
        written.findings = reporter_.take();
        if (!written.findings.empty()) written.bytes.clear();
        return written;
    }

private:
    [[nodiscard]] std::string_view heading_of(std::string_view key) const {
        const bool list = format_.headings == Headings::ide && format_.kind == TableKind::list;
        return list && key == "type" ? "Тип" : heading(key, format_.headings);
    }

    void write_row(const Node& row, std::span<const std::string_view> columns) {
        check_row(row);
        for (std::size_t i = 0; i < columns.size(); ++i)
            put(i,
                format_.headings == Headings::ide ? ide_text(row, columns[i]) : cell_text(row, columns[i]));
        text_ += kLineEnd;
    }

    // Returns true if the reader gives back the same row.
    void check_row(const Node& row) {
        Node back = row;
        settle_row(back, format_.separator != ',', unheard_);
        for (const auto& [key, cell] : row.entries) {
            if (cell.kind != Node::Kind::scalar) continue;
            Column column;
            column.key = key;
            auto again = cell;
            const bool kept = settle_cell(column, again, format_.separator != ',');
            const auto* const settled = back.find(key.text);
            const bool same = kept && again.text == cell.text && settled && settled->text == cell.text;
            if (!same || (cell.text.empty() && key.text == "default"))
                report("file.csv.cannot_hold", key, cell, cell.text.empty() ? "\"\"" : cell.text);
            else if (format_.encoding == Encoding::cp1251 && !first_beyond_cp1251(cell.text).empty())
                report("file.csv.not_in_encoding", key, cell, first_beyond_cp1251(cell.text));
        }
    }

    void report(std::string_view code, const Node& key, const Node& cell, std::string_view value) {
        reporter_.error(
            code, cell.location,
            {.value = std::string(value),
             .path = key.text,
             .arguments = {{"key", key.text}, {"encoding", std::string(name_of(format_.encoding))}}});
    }

    // A register number that looks like a reference is written so that the reader cannot take it for one.
    static std::string cell_text(const Node& row, std::string_view key) {
        std::string text(cell_of(row, key));
        if (key != "register" || !looks_like_reference(text)) return text;
        const auto number = model::parse_integer(text);
        return number ? fmt::format("0x{:X}", number->magnitude) : text;
    }

    // The words of the IDE; what it does not know stays as it is.
    [[nodiscard]] std::string ide_text(const Node& row, std::string_view key) const {
        auto text = cell_text(row, key);
        if (key == kRegistersColumn) return is_double_word(row) ? "2" : "";
        if (key == "read" || key == "write") return ide_function(std::string(function_of(row, key)));
        if (key == "type") return ide_type(text);
        if (key == "default" && cell_of(row, "type") == "bool")
            return text.empty() ? text
                                : std::string(model::parse_bool(text).value_or(text == "1") ? "1" : "0");
        const auto* const field = model::find_field(model::Object::variable, key);
        if (field == nullptr) return text;
        return field->kind == model::Kind::boolean ? ide_flag(key, text) : text;
    }

    [[nodiscard]] std::string ide_flag(std::string_view key, const std::string& text) const {
        const bool order = key == "high_byte_first" || key == "high_register_first";
        const bool ticked = key == "retain" || key == "write_on_change" || order;
        const bool shown = key == "write_on_change" ||
                           (format_.kind != TableKind::variables && (key == "retain" || key == "used"));
        if (text.empty() && !shown) return text;
        const bool on = text.empty() ? key == "used" : model::parse_bool(text).value_or(false);
        if (!ticked || format_.encoding != Encoding::utf8) return on ? "Да" : "Нет";
        return on ? (order ? "☒" : "☑") : "☐";
    }

    static std::string ide_type(const std::string& text) {
        if (text == "bool") return "Булевское";
        if (text == "int" || text == "int16" || text == "int32") return "Целочисленное";
        if (text == "float" || text == "real") return "С плавающей запятой";
        return text;
    }

    static std::string ide_function(const std::string& text) {
        if (text == "none") return "Нет";
        const auto number = model::parse_integer(text);
        return number ? fmt::format("0x{:02X}", number->magnitude) : text;
    }

    void put(std::size_t column, const std::string& text) {
        if (column > 0) text_ += format_.separator;
        const std::array special{format_.separator, '"', '\r', '\n', '\t'};
        const bool plain = text.find_first_of(special.data(), 0, special.size()) == std::string::npos &&
                           !text.starts_with(' ') && !text.ends_with(' ');
        text_ += plain ? text : quoted_cell(text);
    }

    std::optional<std::string> encoded() {
        std::string bytes = format_.byte_order_mark && format_.encoding == Encoding::utf8
                                ? std::string(kByteOrderMark) + text_
                                : text_;
        if (format_.encoding == Encoding::cp1251) {
            auto coded = to_cp1251(text_);
            if (!coded) return std::nullopt;  // and reported, at its cell
            if (to_utf8(*coded, encoding_of(*coded)).text != text_)
                reporter_.error("file.csv.reads_as_utf8", {});
            bytes = *std::move(coded);
        }
        if (bytes.size() > kMaxFileBytes)
            reporter_.error("file.convert.too_large", {}, {.allowed = std::string(kMaxFileText)});
        return bytes;
    }

    TableFormat format_;
    Reporter reporter_;
    Reporter unheard_;
    std::string text_;
};

}  // namespace

Written write_table(const std::vector<Node>& rows, const TableFormat& format) {
    return CsvWriter(format).write(rows);
}

}  // namespace takt::file
