// CSV tables. The first line that is not empty holds the headings.
//
// Choice of the separator:
//   1. the separator given in the options;
//   2. a first line "sep=;", as spreadsheets write and read it;
//   3. the separator of `;`, `,`, tab with which most headings are known; among equals the one that occurs
//      first outside quotes in the first line.
// A separator other than the comma also makes the comma the decimal sign.
#include "csv.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "csv_rows.hpp"
#include "dialect.hpp"
#include "encoding.hpp"
#include "headings.hpp"
#include "nodes.hpp"
#include "takt/file/load.hpp"
#include "takt/model/fields.hpp"
#include "words.hpp"

namespace takt::file {
namespace {

using model::Node;

constexpr std::string_view kSeparators = ";,\t";

struct CsvLayout {
    char separator = ',';
    std::size_t begin = 0;  // offset of the heading line
};

bool is_device_setting(std::string_view key) {
    return std::ranges::find(kDeviceSettings, key) != kDeviceSettings.end();
}

bool is_column(std::string_view key, const TableOptions& options) {
    if (names_place(key)) return options.devices;
    return key == kRegistersColumn || model::find_field(model::Object::variable, key) != nullptr;
}

std::optional<CsvLayout> declared_layout(std::string_view text) {
    constexpr std::string_view kDeclaration = "sep=";
    if (!text.starts_with(kDeclaration) || text.size() <= kDeclaration.size()) return std::nullopt;
    const char separator = text[kDeclaration.size()];
    const auto end = text.find('\n');
    const auto rest = text.substr(kDeclaration.size() + 1, end - kDeclaration.size() - 1);
    if (!kSeparators.contains(separator) || (!rest.empty() && rest != "\r" && rest != "\n" && rest != "\r\n"))
        return std::nullopt;
    return CsvLayout{separator, end == std::string_view::npos ? text.size() : end + 1};
}

std::size_t known_headings(const Source& source, char separator) {
    Reporter unheard;
    const auto row = RowReader(source, 0, separator, unheard).next_filled();
    if (!row) return 0;
    return static_cast<std::size_t>(std::ranges::count_if(
        row->cells, [](const Cell& cell) { return !read_heading(cell.text).key.empty(); }));
}

// The separator that occurs first outside quotes in the first line.
char first_separator(std::string_view text) {
    bool quoted = false;
    for (const char c : text.substr(std::min(text.find_first_not_of("\r\n"), text.size()))) {
        if (c == '"') quoted = !quoted;
        if (!quoted && kSeparators.contains(c)) return c;
        if (!quoted && c == '\n') break;
    }
    return ',';
}

CsvLayout csv_layout_of(const Source& source, const TableOptions& options) {
    if (options.separator != 0) return {options.separator, 0};
    if (const auto declared = declared_layout(source.text())) return *declared;
    CsvLayout layout{first_separator(source.text()), 0};
    auto most = known_headings(source, layout.separator);
    for (const char separator : kSeparators) {
        const auto known = known_headings(source, separator);
        if (known <= most) continue;
        most = known;
        layout.separator = separator;
    }
    return layout;
}

class TableReader {
public:
    TableReader(const Source& source, const TableOptions& options, bool decimal_comma,
                std::size_t& nodes_left, Reporter& reporter)
        : source_(source),
          options_(options),
          decimal_comma_(decimal_comma),
          nodes_left_(nodes_left),
          reporter_(reporter) {}

    void take_header(const Row& header) {
        std::vector<const Cell*> unknown;
        for (const auto& cell : header.cells) {
            auto& column = columns_.emplace_back(read_column(cell));
            if (!column.kept && !column.key.text.empty()) unknown.push_back(&cell);
            keep(column);
        }
        if (options_.strict || (!unknown.empty() && !has_required())) unknown_is_error_ = true;
        for (const auto* const cell : unknown)
            take_unknown(columns_[static_cast<std::size_t>(cell - header.cells.data())], *cell);
    }

    // An unknown column may be the missing required one. Then every row would be incomplete, so none is read.
    [[nodiscard]] bool lacks_a_required_column() const { return unknown_is_error_ && !has_required(); }

    // A row has one address. Of the rows with two, the interpretation gets the first one.
    void drop_second_address(Node& row) {
        constexpr std::array<std::string_view, 3> kAddressKeys{"register", "reference", "coil"};
        const Node::Entry* first = nullptr;
        for (auto& entry : row.entries) {
            if (std::ranges::find(kAddressKeys, entry.key.text) == kAddressKeys.end()) continue;
            if (first == nullptr)
                first = &entry;
            else
                note_two_addresses(*first, entry);
        }
        std::erase_if(row.entries, [&](const Node::Entry& entry) {
            return first != nullptr && &entry != first &&
                   std::ranges::find(kAddressKeys, entry.key.text) != kAddressKeys.end();
        });
    }

    // Use without functions and without keys of polling is the mark of a server's table.
    [[nodiscard]] TableKind kind() const {
        const auto any = [this](auto... keys) { return (has(keys) || ...); };
        if (lists_devices()) return TableKind::devices;
        if (!has("name") || !has("type") || any("read", "write", kDeviceColumn, kUnitAddressColumn))
            return TableKind::variables;
        const bool polled =
            any("write_on_change", "read_trigger", "write_trigger", "status", "period", "deadline",
                "hold_last", "dead_band", "write_range", "verify", "safe_to_repeat");
        if (has("used") && any("register", "coil", "reference") && !polled) return TableKind::served;
        if (any("area", "coil", "reference")) return TableKind::variables;
        if (has("register")) return TableKind::list;
        return !has("bit") && any("retain", "default", "used") ? TableKind::locals : TableKind::variables;
    }

    [[nodiscard]] TableShape shape() const {
        const auto kind = this->kind();
        return {.unaddressed = kind == TableKind::served || kind == TableKind::list,
                .functions = has("read") && has("write")};
    }

    // Returns nothing, after a report, if a cell of the row has no column. Of columns with equal names only
    // the first one counts.
    std::optional<Node> mapping(const Row& row) {
        Node node;
        node.kind = Node::Kind::mapping;
        node.location = source_.location(row.cells.front().offset);
        std::optional<Node::Entry> notes;
        for (std::size_t i = 0; i < row.cells.size(); ++i) {
            const auto& cell = row.cells[i];
            if (cell.text.empty()) continue;
            if (i >= columns_.size() || columns_[i].key.text.empty()) {
                const auto* code =
                    i >= columns_.size() ? "file.csv.too_many_cells" : "file.csv.no_column_name";
                reporter_.error(code, source_.location(cell.offset),
                                {.value = cell.text, .allowed = std::to_string(columns_.size())});
                return std::nullopt;
            }
            if (columns_[i].noted) note(notes, columns_[i], scalar(cell));
            if (!columns_[i].kept) continue;
            if (columns_[i].key.text == "name" && is_placeholder(cell.text)) return empty_row(node);
            auto value = scalar(cell);
            if (settle_cell(columns_[i], value, decimal_comma_) && !is_second(node, columns_[i], value))
                node.entries.emplace_back(columns_[i].key, std::move(value));
        }
        append_notes(node, std::move(notes));
        settle_row(node, decimal_comma_, reporter_);
        return node;
    }

    // Returns false, after a report, if the limit of nodes is exceeded.
    bool count(const Node& row) {
        const auto nodes = 1 + 2 * row.entries.size();
        if (nodes > nodes_left_) {
            reporter_.error("file.too_many_nodes", row.location, {.allowed = std::to_string(kMaxNodes)});
            nodes_left_ = 0;
            return false;
        }
        nodes_left_ -= nodes;
        return true;
    }

    /// One finding for all comments that were too long.
    void report_cut_comments() {
        if (cut_rows_ > 0)
            reporter_.warning("file.csv.comment_cut", first_cut_location_,
                              {.value = first_cut_, .arguments = {{"count", std::to_string(cut_rows_)}}});
    }

private:
    [[nodiscard]] bool has(std::string_view key) const {
        return std::ranges::any_of(
            columns_, [&](const Column& column) { return column.kept && column.key.text == key; });
    }

    // Settings of devices, and no variables.
    [[nodiscard]] bool lists_devices() const {
        return std::ranges::any_of(kDeviceSettings, [this](auto key) { return has(key); }) && !has("type") &&
               (has("name") || has(kDeviceColumn));
    }

    [[nodiscard]] bool has_required() const {
        return lists_devices() ||
               std::ranges::all_of(model::fields(model::Object::variable),
                                   [&](const auto& field) { return !field.required || has(field.key); });
    }

    // Of columns with equal names only the first one counts. A window shows the order of the bytes twice,
    // under different names.
    void keep(Column& column) {
        if (!column.kept) return;
        const auto [first, added] = first_columns_.emplace(column.key.text, columns_.size());
        if (!added && column.key.text == "byte_order" &&
            folded(column.heading) != folded(columns_[first->second - 1].heading))
            return;
        column.kept = added;
        if (!added) report_two_columns(column, columns_[first->second - 1]);
    }

    Column read_column(const Cell& cell) {
        Column column;
        column.key = scalar(cell);
        column.heading = cell.text;
        if (cell.text.empty()) return column;
        auto parts = read_heading(cell.text);
        if (parts.ambiguous) settle_ambiguous(parts, column.key);
        if (!is_column(parts.key, options_)) return column;
        column.key.text = parts.key;
        column.kept = true;
        column.unit = parts.unit;
        column.hexadecimal = parts.hexadecimal;
        return column;
    }

    // `Функция ...` may be either function. The IDE has the read function before the write function, and the
    // address of the register before that of the bit.
    void settle_ambiguous(HeadingParts& parts, const Node& column) {
        if (has(parts.key) && parts.key == "read") parts.key = "write";
        if (has(parts.key) && parts.key == "register") parts.key = "bit";
        reporter_.warning(
            "file.csv.column_ambiguous", column.location,
            {.value = column.text, .arguments = {{"meant", std::string(heading(parts.key, Headings::ide))}}});
    }

    // The cells under a misspelt heading are read under the likely name. Those under another unknown heading
    // become comments.
    void take_unknown(Column& column, const Cell& cell) {
        if (!unknown_is_error_ && is_device_setting(read_heading(cell.text).key))
            return reporter_.warning("file.csv.column_of_device", column.key.location, {.value = cell.text});
        const auto likely = likely_heading(cell.text);
        const bool misspelt = likely.typing_mistake && is_column(likely.key, options_) && !has(likely.key);
        const auto* const code = unknown_is_error_ ? "file.csv.unknown_column"
                                 : misspelt        ? "file.csv.column_taken_as"
                                                   : "file.csv.column_as_comment";
        Details details{.value = cell.text, .arguments = {{"nearest", std::string(likely.heading)}}};
        if (unknown_is_error_)
            reporter_.error(code, column.key.location, std::move(details));
        else
            reporter_.warning(code, column.key.location, std::move(details));
        column.noted = !unknown_is_error_ && !misspelt;
        if (!misspelt) return;
        column.key.text = likely.key;
        column.kept = true;
    }

    // Whether another column has already given the value. Another value is reported.
    bool is_second(const Node& row, const Column& column, const Node& value) {
        const auto* const first = column.key.text == "byte_order" ? row.find("byte_order") : nullptr;
        if (first == nullptr) return false;
        if (first->text != value.text)
            reporter_.error(
                "file.convert.two_values", value.location,
                {.value = value.text, .arguments = {{"key", column.key.text}, {"first", first->text}}});
        return true;
    }

    // `Heading: cell`, joined with those before it.
    static void note(std::optional<Node::Entry>& notes, const Column& column, Node cell) {
        if (is_placeholder(cell.text)) return;
        cell.text = column.key.text + ": " + cell.text;
        if (notes) {
            notes->value.text += "; " + cell.text;
            return;
        }
        auto key = column.key;
        key.text = "comment";
        notes.emplace(std::move(key), std::move(cell));
    }

    [[nodiscard]] std::string number_of(const Column& column) const {
        return std::to_string(&column - columns_.data() + 1);
    }

    // Columns with which users confuse that of the register, beside other headings.
    void report_two_columns(const Column& second, const Column& first) {
        const bool address = second.key.text == "register";
        reporter_.error(address ? "file.csv.two_registers" : "file.csv.duplicate_column", second.key.location,
                        {.value = second.heading,
                         .arguments = {{"first", first.heading},
                                       {"first_column", number_of(first)},
                                       {"column", number_of(second)},
                                       {"key", second.key.text}}});
    }

    void note_two_addresses(const Node::Entry& first, const Node::Entry& second) {
        const auto column = [&](const Node::Entry& entry) -> const Column& {
            return *std::ranges::find(columns_, entry.key.location,
                                      [](const Column& c) { return c.key.location; });
        };
        if (!two_addresses_.insert(second.key.text).second) return;
        const auto& one = column(first);
        const auto& other = column(second);
        reporter_.error("file.csv.two_addresses", other.key.location,
                        {.value = other.heading,
                         .arguments = {{"first", one.heading},
                                       {"first_column", number_of(one)},
                                       {"column", number_of(other)},
                                       {"row", std::to_string(second.value.location.line)}}});
    }

    void append_notes(Node& row, std::optional<Node::Entry> notes) {
        if (!notes || row.entries.empty()) return;
        const auto comment = std::ranges::find_if(
            row.entries, [](const Node::Entry& entry) { return entry.key.text == "comment"; });
        if (comment != row.entries.end()) {
            notes->value.text = comment->value.text + "; " + notes->value.text;
            row.entries.erase(comment);
        }
        auto [comment_text, cut] = as_comment(notes->value.text);
        if (!cut.empty() && ++cut_rows_ == 1) {
            first_cut_ = std::move(cut);
            first_cut_location_ = notes->value.location;
        }
        notes->value.text = std::move(comment_text);
        row.entries.push_back(*std::move(notes));
    }

    static Node empty_row(Node row) {
        row.entries.clear();
        return row;
    }

    [[nodiscard]] Node scalar(const Cell& cell) const {
        Node node;
        node.kind = Node::Kind::scalar;
        node.location = source_.location(cell.offset);
        node.text = cell.text;
        node.quoted = cell.quoted;
        node.cell = true;
        return node;
    }

    const Source& source_;
    const TableOptions& options_;
    bool decimal_comma_;
    std::size_t& nodes_left_;
    Reporter& reporter_;
    std::vector<Column> columns_;
    std::map<std::string, std::size_t, std::less<>> first_columns_;  // counted from one
    bool unknown_is_error_ = false;
    std::set<std::string> two_addresses_;  // keys of the second columns
    std::size_t cut_rows_ = 0;
    std::string first_cut_;
    model::SourceLocation first_cut_location_;
};

// The heading line without trailing empty cells; nothing, after a report, if there is none.
std::optional<Row> read_header(RowReader& rows, const Source& source, Reporter& reporter) {
    auto header = rows.next_filled();
    if (!header) {
        reporter.error("file.csv.no_header", source.location(0));
        return std::nullopt;
    }
    if (header->damaged) return std::nullopt;
    while (header->cells.back().text.empty()) header->cells.pop_back();
    if (header->cells.size() <= kMaxColumns) return header;
    reporter.error("file.csv.too_many_columns", source.location(header->cells.front().offset),
                   {.allowed = std::to_string(kMaxColumns)});
    return std::nullopt;
}

// The fields of one device or variable as a window shows them: a name and a value in each line.
struct PropertyWindow {
    Row names;
    Row values;
};

std::string_view key_of(const Cell& cell) {
    return read_heading(cell.text).key;
}

// Makes a line of a window a name and a value. A check box may stand before its name, the order of the bytes
// in several cells or behind a colon, and the button of a list behind its value. Returns false if it has more
// cells.
bool settle_window_line(std::vector<Cell>& cells) {
    const auto is_empty = [](const Cell& cell) {
        return cell.text.empty() || cell.text == "..." || cell.text == "…";
    };
    while (cells.size() > 2 && is_empty(cells.back())) cells.pop_back();
    if (cells.size() < 2) cells.push_back({cells[0].offset, {}, false});
    if (const auto box = split_box(cells[0].text); box && cells[1].text.empty()) {
        cells[1].text = box->state;
        cells[0].text = std::string(box->label);
    }
    if (const auto colon = cells[0].text.find(':'); cells[1].text.empty() && colon < cells[0].text.size()) {
        cells[1].text = cells[0].text.substr(
            std::min(cells[0].text.find_first_not_of(" \t", colon + 1), cells[0].text.size()));
        cells[0].text.erase(colon);
    }
    for (; cells.size() > 2 && key_of(cells[0]) == "byte_order"; cells.erase(cells.begin() + 2))
        cells[1].text += ' ' + cells[2].text;
    return cells.size() == 2;
}

// Whether two columns with headings are meant although their rows are named like fields: `Имя;Тип` over
// types. The first line of a window may have the name of a field as its value: `Имя;Устройство`.
bool is_table_of_types(const PropertyWindow& window) {
    const auto& values = window.values.cells;
    return key_of(window.names.cells[0]) == "name" && key_of(values[0]) == "type" &&
           std::all_of(values.begin() + 1, values.end(), [](const Cell& cell) {
               return std::ranges::find(model::kTypes, cell.text) != model::kTypes.end() ||
                      type_word(cell.text);
           });
}

// Returns nothing if the text is a table with a line of headings.
std::optional<PropertyWindow> read_property_window(const Source& source, const CsvLayout& layout) {
    constexpr std::size_t kLeast = 3;
    constexpr std::array<std::string_view, 3> kValueWords{"значение", "value", "значення"};
    Reporter unheard;
    RowReader rows(source, layout.begin, layout.separator, unheard);
    PropertyWindow window;
    std::set<std::string_view> known;
    while (auto row = rows.next()) {
        if (row->empty() && !row->damaged) continue;
        if (row->damaged || window.names.cells.size() >= kMaxColumns || !settle_window_line(row->cells))
            return std::nullopt;
        const auto heading = folded(row->cells[1].text);
        if (window.names.cells.empty() && std::ranges::find(kValueWords, heading) != kValueWords.end())
            continue;
        known.insert(key_of(row->cells[0]));
        window.names.cells.push_back(std::move(row->cells[0]));
        window.values.cells.push_back(std::move(row->cells[1]));
    }
    known.erase(std::string_view());
    if (known.size() < kLeast || 2 * known.size() <= window.names.cells.size() || is_table_of_types(window))
        return std::nullopt;
    return window;
}

}  // namespace

Contents read_csv(const Source& source, const TableOptions& options, std::size_t& nodes_left,
                  Reporter& reporter) {
    Contents contents;
    auto& list = contents.rows;
    list.kind = Node::Kind::list;
    list.location = source.location(0);
    const auto layout = csv_layout_of(source, options);
    RowReader rows(source, layout.begin, layout.separator, reporter);
    const auto header = read_header(rows, source, reporter);
    if (!header) return contents;
    TableReader table(source, options, layout.separator != ',', nodes_left, reporter);
    const auto window = read_property_window(source, layout);
    table.take_header(window ? window->names : *header);
    if (table.lacks_a_required_column()) return contents;
    contents.kind = table.kind();
    bool taken = false;
    const auto next = [&] {
        if (!window) return rows.next();
        return std::exchange(taken, true) ? std::nullopt : std::optional(window->values);
    };
    while (const auto row = next()) {
        if (row->damaged || row->empty()) continue;
        auto mapping = table.mapping(*row);
        if (!mapping || mapping->entries.empty()) continue;
        table.drop_second_address(*mapping);
        if (!table.count(*mapping)) break;
        list.items.push_back(*std::move(mapping));
    }
    table.report_cut_comments();
    if (contents.kind != TableKind::devices) settle_addresses(list, options, table.shape(), reporter);
    return contents;
}

Contents read_csv_bytes(std::uint32_t file, const std::string& bytes, const TableOptions& options,
                        std::size_t& nodes_left, Reporter& reporter) {
    const auto decoded = to_utf8(bytes, options.encoding.value_or(encoding_of(bytes)));
    const Source source(file, decoded.text);
    const auto foreign = find_foreign(source.text());
    if (foreign || decoded.stopped_at) {
        const auto& wrong = foreign ? *foreign : *decoded.stopped_at;
        const auto* const code = wrong.utf8                       ? "file.control_character"
                                 : decoded.stopped_at && !foreign ? "file.not_cp1251"
                                                                  : "file.not_utf8";
        reporter.error(code, source.location(wrong.offset), {.value = in_words(wrong)});
        return {.rows = {.kind = Node::Kind::list, .location = {.file = file}}};
    }
    return read_csv(source, options, nodes_left, reporter);
}

}  // namespace takt::file
