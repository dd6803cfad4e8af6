// Writes CSV tables. Every cell is checked with the reader itself, so that reading the table back gives the
// same values.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>

#include "dialect.hpp"
#include "encoding.hpp"
#include "headings.hpp"
#include "reporter.hpp"
#include "takt/file/table.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/scalar.hpp"

namespace takt::file {
namespace {

using model::Node;

constexpr std::array kPlaceColumns{kLineColumn, kDeviceColumn, kUnitAddressColumn};
constexpr std::array<std::string_view, 7> kIdeColumns{"name",     "type", "read",   "write",
                                                      "register", "bit",  "comment"};
constexpr std::string_view kLineEnd = "\r\n";
constexpr std::string_view kLimitInWords = "8 MiB";

std::string_view name_of(Encoding encoding) {
    return encoding == Encoding::utf8 ? "UTF-8" : "CP1251";
}

bool has_value(const Node& row, std::string_view key) {
    const auto* const cell = row.find(key);
    return cell != nullptr && cell->kind == Node::Kind::scalar;
}

std::vector<std::string_view> columns_of(const std::vector<Node>& rows) {
    const auto used = [&](std::string_view key) {
        return std::ranges::any_of(rows, [&](const Node& row) { return has_value(row, key); });
    };
    std::vector<std::string_view> columns;
    for (const auto key : kPlaceColumns)
        if (used(key)) columns.push_back(key);
    columns.insert(columns.end(), kIdeColumns.begin(), kIdeColumns.end());
    for (const auto& field : model::fields(model::Object::variable))
        if (std::ranges::find(kIdeColumns, field.key) == kIdeColumns.end() && used(field.key))
            columns.push_back(field.key);
    return columns;
}

std::string quoted(std::string_view text) {
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"') result += '"';
        result += c;
    }
    return result + '"';
}

class Writer {
public:
    explicit Writer(const TableFormat& format) : format_(format) {}

    Written write(const std::vector<Node>& rows) {
        const auto columns = columns_of(rows);
        for (std::size_t i = 0; i < columns.size(); ++i)
            put(i, std::string(heading(columns[i], format_.headings)));
        text_ += kLineEnd;
        for (const auto& row : rows) write_row(row, columns);
        Written written;
        if (auto bytes = encoded()) written.bytes = *std::move(bytes);
        written.findings = reporter_.take();
        if (!written.findings.empty()) written.bytes.clear();
        return written;
    }

private:
    void write_row(const Node& row, std::span<const std::string_view> columns) {
        check_row(row);
        for (std::size_t i = 0; i < columns.size(); ++i)
            put(i, has_value(row, columns[i]) ? cell_text(columns[i], *row.find(columns[i])) : std::string());
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
    static std::string cell_text(std::string_view key, const Node& cell) {
        if (key != "register" || !looks_like_reference(cell.text)) return cell.text;
        const auto number = model::parse_integer(cell.text);
        return number ? fmt::format("0x{:X}", number->magnitude) : cell.text;
    }

    void put(std::size_t column, const std::string& text) {
        if (column > 0) text_ += format_.separator;
        const std::array special{format_.separator, '"', '\r', '\n', '\t'};
        const bool plain = text.find_first_of(special.data(), 0, special.size()) == std::string::npos &&
                           !text.starts_with(' ') && !text.ends_with(' ');
        text_ += plain ? text : quoted(text);
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
            reporter_.error("file.convert.too_large", {}, {.allowed = std::string(kLimitInWords)});
        return bytes;
    }

    TableFormat format_;
    Reporter reporter_;
    Reporter unheard_;
    std::string text_;
};

}  // namespace

Written write_table(const std::vector<Node>& rows, const TableFormat& format) {
    return Writer(format).write(rows);
}

}  // namespace takt::file
