// CSV tables and windows (csv_parts.hpp). A table below the window of a device holds the variables of that
// device. A separator other than the comma also makes the comma the decimal sign.
#include "tables/csv.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tables/cell_words.hpp"
#include "tables/csv_parts.hpp"
#include "tables/dialect.hpp"
#include "tables/encoding.hpp"
#include "tables/headings.hpp"
#include "takt/file/load.hpp"
#include "takt/model/fields.hpp"
#include "yaml/nodes.hpp"

namespace takt::file {
namespace {

using model::Node;

bool is_device_setting(std::string_view key) {
    return std::ranges::find(kDeviceSettings, key) != kDeviceSettings.end();
}

bool is_column(std::string_view key, const TableOptions& options) {
    if (names_place(key)) return options.devices;
    return key == kRegistersColumn || model::find_field(model::Object::variable, key) != nullptr;
}

class TableReader {
public:
    TableReader(const Source& source, const TableOptions& options, const Part& part, std::size_t& nodes_left,
                Reporter& reporter)
        : source_(source),
          options_(options),
          window_(part.window),
          decimal_comma_(part.separator != ','),
          nodes_left_(nodes_left),
          reporter_(reporter) {}

    /// Nothing, after a report, if a required column is missing.
    std::optional<Contents> read(const Part& part) {
        take_header(part.names);
        if (lacks_a_required_column()) return std::nullopt;
        Contents contents{.rows = {.kind = Node::Kind::list, .location = source_.location(0)},
                          .kind = kind()};
        auto& list = contents.rows;
        RowReader rows(source_, part.begin, part.separator, reporter_);
        bool taken = false;
        const auto next = [&]() -> std::optional<Row> {
            if (!window_) return rows.offset() < part.end ? rows.next() : std::nullopt;
            return std::exchange(taken, true) ? std::nullopt : std::optional(part.values);
        };
        while (const auto row = next()) {
            if (row->damaged || row->empty()) continue;
            auto node = mapping(*row);
            if (!node || node->entries.empty()) continue;
            drop_second_address(*node);
            if (!count(*node)) break;
            list.items.push_back(*std::move(node));
        }
        report_cut_comments();
        if (contents.kind == TableKind::variables) drop_rows_without_device(list);
        if (contents.kind != TableKind::devices) settle_addresses(list, options_, shape(), reporter_);
        return contents;
    }

private:
    void take_header(const Row& header) {
        std::vector<const Cell*> unknown;
        for (const auto& cell : header.cells) {
            auto& column = columns_.emplace_back(read_column(cell));
            if (!column.kept && !column.key.text.empty()) unknown.push_back(&cell);
            keep(column);
        }
        if (options_.strict || (!unknown.empty() && !has_required())) unknown_is_error_ = true;
        if (unknown_is_error_ && is_no_header(unknown))
            return reporter_.error("file.csv.no_header", source_.location(unknown.front()->offset));
        for (const auto* const cell : unknown)
            take_unknown(columns_[static_cast<std::size_t>(cell - header.cells.data())], *cell);
    }

    // Whether few cells of the first line are like headings: the table begins with its rows.
    [[nodiscard]] bool is_no_header(const std::vector<const Cell*>& cells) const {
        const auto alike = std::ranges::count_if(
            cells, [](const Cell* cell) { return likely_heading(cell->text).typing_mistake; });
        return std::ranges::none_of(columns_, &Column::kept) && 2 * alike < std::ssize(cells);
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
        const auto any = [this](auto... keys) { return (has(keys) || ...); };
        const bool addressed = !has("name") || any("read", "write", "area", "coil", "reference");
        return {.unaddressed = kind() == TableKind::served || !addressed,
                .functions = has("read") && has("write")};
    }

    // Spreadsheets write the value of merged cells in the first row only. Rows of one device need none.
    void drop_rows_without_device(Node& list) {
        const auto device_of = [](const Node& row) {
            const auto name = text_of(row, kDeviceColumn);
            return name.empty() ? text_of(row, kUnitAddressColumn) : name;
        };
        std::set<std::string> devices;
        for (const auto& row : list.items) devices.insert(device_of(row));
        if (!devices.erase("") || devices.size() < (has(kDeviceColumn) ? 1 : 2)) return;
        const auto& column =
            columns_[first_columns_.find(has(kDeviceColumn) ? kDeviceColumn : kUnitAddressColumn)->second -
                     1];
        std::erase_if(list.items, [&](const Node& row) {
            if (!device_of(row).empty()) return false;
            reporter_.error("file.csv.no_device", row.location, {.value = column.heading});
            return true;
        });
    }

    // Without its address a device would get that of another table, or the next free one.
    [[nodiscard]] bool is_device_address(const Column& column) const {
        return column.kept && (column.key.text == "register" || column.key.text == kUnitAddressColumn) &&
               lists_devices();
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
            if (cell.text.empty()) {
                if (i < columns_.size() && is_device_address(columns_[i]))
                    reporter_.error("file.csv.no_address", source_.location(cell.offset),
                                    {.value = columns_[i].heading});
                continue;
            }
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

    // One finding for all comments that were too long.
    void report_cut_comments() {
        if (cut_rows_ > 0)
            reporter_.warning("file.csv.comment_cut", first_cut_location_,
                              {.value = first_cut_, .arguments = {{"count", std::to_string(cut_rows_)}}});
    }

    [[nodiscard]] bool has(std::string_view key) const {
        return std::ranges::any_of(
            columns_, [&](const Column& column) { return column.kept && column.key.text == key; });
    }

    // Settings of devices, and no variables.
    [[nodiscard]] bool lists_devices() const {
        if (window_) return is_device_window();
        return std::ranges::any_of(kDeviceSettings, [this](auto key) { return has(key); }) && !has("type") &&
               (has("name") || has(kDeviceColumn));
    }

    // A window shows one device or one variable. Those of a device have no type and no register.
    [[nodiscard]] bool is_device_window() const {
        constexpr std::array<std::string_view, 8> kBoth{
            "period",  "status",      "byte_order",      "high_byte_first", "high_register_first",
            "comment", kDeviceColumn, kUnitAddressColumn};
        constexpr std::array<std::string_view, 10> kNames{"имя",    "название",     "наименование", "імя",
                                                          "назва",  "наименування", "name",         "адрес",
                                                          "адреса", "address"};
        bool device = false;
        for (const auto& column : columns_) {
            const auto key = read_heading(column.heading).key;
            const bool setting = is_device_setting(key) || key == kUnitAddressColumn || key == "register";
            const bool named = key == "name" || key == "register";
            if (named
                    ? std::ranges::find(kNames, folded(column.heading)) == kNames.end()
                    : !key.empty() && !is_device_setting(key) && std::ranges::find(kBoth, key) == kBoth.end())
                return false;
            device = device || setting;
        }
        return device;
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
        auto parts = window_ ? read_field_name(cell.text) : read_heading(cell.text);
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
        if (!unknown_is_error_ && is_device_setting(read_heading(cell.text).key)) {
            if (!lists_devices())  // else the whole table is refused
                reporter_.warning("file.csv.column_of_device", column.key.location, {.value = cell.text});
            return;
        }
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
    bool window_;
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

// The headings without trailing empty cells. Returns false, after a report, if the limit is exceeded.
bool settle_headings(Part& part, const Source& source, Reporter& reporter) {
    auto& cells = part.names.cells;
    if (part.names.damaged) return false;
    while (!part.window && cells.back().text.empty()) cells.pop_back();
    if (cells.size() <= kMaxColumns) return true;
    reporter.error("file.csv.too_many_columns", source.location(cells.front().offset),
                   {.allowed = std::to_string(kMaxColumns)});
    return false;
}

// Joins the parts of a text.
class Joiner {
public:
    Joiner(const Source& source, Reporter& reporter) : source_(source), reporter_(reporter) {
        contents_.rows.kind = Node::Kind::list;
        contents_.rows.location = source.location(0);
    }

    void add(const Part& part, Contents its) {
        const bool window = std::exchange(window_, part.window);
        const auto kind = std::exchange(last_, its.kind);
        const bool variables = its.kind != TableKind::devices && its.kind != TableKind::locals;
        const bool more = variables && window && part.window && kind == its.kind;
        if (first_) {
            contents_.kind = its.kind;
        } else if (contents_.kind == TableKind::devices && variables) {
            auto& device = contents_.rows.items.back();
            if (!more && (!window || kind != TableKind::devices)) return report(part);
            if (!more) set(device, "variables", {.kind = Node::Kind::list, .location = its.rows.location});
            return move_rows(its.rows, *find_value(device, "variables"));
        } else if (!more && (its.kind != TableKind::devices || contents_.kind != TableKind::devices)) {
            return report(part);
        }
        first_ = false;
        move_rows(its.rows, contents_.rows);
    }

    Contents take() { return std::move(contents_); }

private:
    static void move_rows(Node& from, Node& to) {
        std::ranges::move(from.items, std::back_inserter(to.items));
    }

    void report(const Part& part) {
        const auto& cell = part.names.cells.front();
        reporter_.error("file.csv.several_tables", source_.location(cell.offset), {.value = cell.text});
    }

    const Source& source_;
    Reporter& reporter_;
    Contents contents_;
    bool first_ = true;
    bool window_ = false;  // the last part
    TableKind last_ = TableKind::variables;
};

}  // namespace

Contents read_csv(const Source& source, const TableOptions& options, std::size_t& nodes_left,
                  Reporter& reporter) {
    Joiner joiner(source, reporter);
    for (auto& part : divide(source, options.separator, reporter)) {
        if (!settle_headings(part, source, reporter)) continue;
        TableReader table(source, options, part, nodes_left, reporter);
        if (auto contents = table.read(part)) joiner.add(part, *std::move(contents));
    }
    return joiner.take();
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
