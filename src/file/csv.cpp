// The format: records of cells, a line each. The header line tells the separator: the first `;` or `,`
// outside quotes. A cell in quotes may hold separators, line breaks and, doubled, quotes; spaces around cells
// do not count. A quote inside a cell that does not begin with one is a character like others.
#include "csv.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "takt/file/load.hpp"

namespace takt::file {
namespace {

using model::Node;

constexpr std::string_view kBlank = " \t";
constexpr std::size_t kMaxColumns = 256;

struct Cell {
    std::size_t offset = 0;
    std::string text;
    bool quoted = false;
};

struct Row {
    std::vector<Cell> cells;
    bool damaged = false;  // and reported

    [[nodiscard]] bool empty() const {
        return std::ranges::all_of(cells, [](const Cell& cell) { return cell.text.empty(); });
    }
};

char separator_of(std::string_view text) {
    bool quoted = false;
    for (const char c : text) {
        if (c == '"') quoted = !quoted;
        if (!quoted && (c == ';' || c == ',')) return c;
        if (!quoted && c == '\n') break;
    }
    return ',';
}

// Takes rows off a text, from its beginning to its end.
class RowReader {
public:
    RowReader(const Source& source, Reporter& reporter)
        : source_(source), text_(source.text()), separator_(separator_of(text_)), reporter_(reporter) {}

    std::optional<Row> next() {
        if (at_ >= text_.size()) return std::nullopt;
        Row row;
        do {
            auto next_cell = cell(row);
            if (row.cells.size() <= kMaxColumns) row.cells.push_back(std::move(next_cell));
        } while (take(separator_));
        take('\r');
        take('\n');
        return row;
    }

private:
    bool take(char c) {
        if (at_ >= text_.size() || text_[at_] != c) return false;
        ++at_;
        return true;
    }

    [[nodiscard]] std::size_t end_of_plain() const {
        const std::array<char, 4> ends{separator_, '\r', '\n', '\0'};
        return std::min(text_.find_first_of(ends.data(), at_), text_.size());
    }

    Cell cell(Row& row) {
        at_ = std::min(text_.find_first_not_of(kBlank, at_), text_.size());
        Cell cell{at_, {}, take('"')};
        if (cell.quoted) cell.text = quoted(row, cell.offset);
        const auto plain = text_.substr(at_, end_of_plain() - at_);
        const auto trimmed = plain.substr(0, plain.find_last_not_of(kBlank) + 1);
        if (!cell.quoted) {
            cell.text = trimmed;
        } else if (!trimmed.empty()) {
            damage(row, "file.csv.after_quote", at_ + trimmed.find_first_not_of(kBlank));
        }
        at_ += plain.size();
        return cell;
    }

    std::string quoted(Row& row, std::size_t open) {
        std::string text;
        for (;;) {
            const auto quote = text_.find('"', at_);
            text += text_.substr(at_, quote - at_);
            at_ = std::min(quote, text_.size());
            if (!take('"')) {
                damage(row, "file.csv.unclosed_quote", open);
                return text;
            }
            if (!take('"')) return text;
            text += '"';
        }
    }

    void damage(Row& row, std::string_view code, std::size_t offset) {
        reporter_.error(code, source_.place(offset));
        row.damaged = true;
    }

    const Source& source_;
    std::string_view text_;
    char separator_;
    Reporter& reporter_;
    std::size_t at_ = 0;
};

struct Column {
    Node key;
    bool kept = false;
};

class Table {
public:
    Table(const Source& source, std::size_t& nodes_left, Reporter& reporter)
        : source_(source), nodes_left_(nodes_left), reporter_(reporter) {}

    void take_header(const Row& header) {
        std::unordered_map<std::string_view, std::uint32_t> seen;
        for (const auto& cell : header.cells) {
            auto& column = columns_.emplace_back();
            column.key = scalar(cell);
            const auto [first, added] = seen.emplace(cell.text, column.key.place.column);
            column.kept = added && !cell.text.empty();
            if (!added && !cell.text.empty())
                reporter_.error(
                    "file.csv.duplicate_column", column.key.place,
                    {.value = cell.text, .arguments = {{"first", std::to_string(first->second)}}});
        }
    }

    // nullopt, and reported: the row has a cell without a column. A column named twice counts once.
    std::optional<Node> mapping(const Row& row) {
        Node node;
        node.kind = Node::Kind::mapping;
        node.place = source_.place(row.cells.front().offset);
        for (std::size_t i = 0; i < row.cells.size(); ++i) {
            const auto& cell = row.cells[i];
            if (cell.text.empty()) continue;
            if (i >= columns_.size() || columns_[i].key.text.empty()) {
                const auto* code =
                    i >= columns_.size() ? "file.csv.too_many_cells" : "file.csv.no_column_name";
                reporter_.error(code, source_.place(cell.offset),
                                {.value = cell.text, .allowed = std::to_string(columns_.size())});
                return std::nullopt;
            }
            if (columns_[i].kept) node.entries.emplace_back(columns_[i].key, scalar(cell));
        }
        return node;
    }

    // False, and reported, when there are not as many left.
    bool count(const Node& row) {
        const auto nodes = 1 + 2 * row.entries.size();
        if (nodes > nodes_left_) {
            reporter_.error("file.too_many_nodes", row.place, {.allowed = std::to_string(kMaxNodes)});
            nodes_left_ = 0;
            return false;
        }
        nodes_left_ -= nodes;
        return true;
    }

private:
    [[nodiscard]] Node scalar(const Cell& cell) const {
        Node node;
        node.kind = Node::Kind::scalar;
        node.place = source_.place(cell.offset);
        node.text = cell.text;
        node.quoted = cell.quoted;
        return node;
    }

    const Source& source_;
    std::size_t& nodes_left_;
    Reporter& reporter_;
    std::vector<Column> columns_;
};

}  // namespace

Node read_csv(const Source& source, std::size_t& nodes_left, Reporter& reporter) {
    Node list;
    list.kind = Node::Kind::list;
    list.place = source.place(0);
    RowReader rows(source, reporter);
    const auto header = rows.next();
    if (!header || header->empty()) {
        reporter.error("file.csv.no_header", list.place);
        return list;
    }
    if (header->damaged) return list;
    if (header->cells.size() > kMaxColumns) {
        reporter.error("file.csv.too_many_columns", list.place, {.allowed = std::to_string(kMaxColumns)});
        return list;
    }
    Table table(source, nodes_left, reporter);
    table.take_header(*header);
    while (const auto row = rows.next()) {
        if (row->damaged || row->empty()) continue;
        auto mapping = table.mapping(*row);
        if (!mapping) continue;
        if (!table.count(*mapping)) break;
        list.items.push_back(*std::move(mapping));
    }
    return list;
}

}  // namespace takt::file
