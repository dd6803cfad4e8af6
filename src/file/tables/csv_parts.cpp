// A text is read line by line. A line may be of an IDE's tree, a field of a window, or a line of headings.
// The rows below headings belong to that table until the next part begins.
//
// Choice of the separator of a table:
//   1. the separator given in the options;
//   2. a first line "sep=;", as spreadsheets write and read it;
//   3. the separator of `;`, `,`, tab with which most headings are known; among equals the one that occurs
//      first outside quotes in the first line.
// The line of a window may also have a colon. Its separator is the first one that gives a known field.
#include "tables/csv_parts.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "tables/cell_words.hpp"
#include "tables/headings.hpp"
#include "takt/base/ascii.hpp"
#include "takt/file/table.hpp"
#include "takt/model/fields.hpp"

namespace takt::file {
namespace {

constexpr std::string_view kSeparators = ";,\t";
constexpr char kNoSeparator = '\x1f';  // never in a text; the line is one cell

struct CsvLayout {
    char separator = ',';
    std::size_t begin = 0;  // offset of the heading line
};

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

std::string_view key_of(const Cell& cell) {
    return read_heading(cell.text).key;
}

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view kBlanks = " \t\r";
    text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
    return text.substr(0, text.find_last_not_of(kBlanks) + 1);
}

// `RS485`, `Слот 1`, `Master`: what an IDE's tree shows above a device.
bool is_tree_word(std::string_view text) {
    constexpr std::array<std::string_view, 4> kWhole{"rs485", "rs232", "master", "slave"};
    const auto word = folded(text);
    for (const std::string_view slot : {"слот", "slot"})
        if (word.starts_with(slot)) return all_digits(word.substr(slot.size()));
    return std::ranges::find(kWhole, std::string_view(word)) != kWhole.end();
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
        cells[0].text = trimmed(std::string_view(cells[0].text).substr(0, colon));
    }
    for (; cells.size() > 2 && key_of(cells[0]) == "byte_order"; cells.erase(cells.begin() + 2))
        cells[1].text += ' ' + cells[2].text;
    return cells.size() == 2;
}

// Whether two columns with headings are meant although their rows are named like fields: `Имя;Тип` over
// types. The first line of a window may have the name of a field as its value: `Имя;Устройство`.
bool has_headings(const Part& window) {
    const auto& values = window.values.cells;
    const auto name = key_of(window.names.cells[0]);
    const auto value = key_of(values[0]);
    if (name != "name") return !name.empty() && !value.empty();
    return value == "type" && std::all_of(values.begin() + 1, values.end(), [](const Cell& cell) {
               return std::ranges::find(model::kTypes, cell.text) != model::kTypes.end() ||
                      type_word(cell.text);
           });
}

void put(Part& window, Cell name, Cell value) {
    window.names.cells.push_back(std::move(name));
    window.values.cells.push_back(std::move(value));
}

class Divider {
public:
    Divider(const Source& source, char separator, Reporter& reporter)
        : source_(source), text_(source.text()), separator_(separator), reporter_(reporter) {}

    std::vector<Part> divide() {
        if (const auto declared = separator_ == 0 ? declared_layout(text_) : std::nullopt) {
            separator_ = declared->separator;
            at_ = declared->begin;
        }
        for (at_ = filled_from(at_); at_ < text_.size(); at_ = filled_from(at_)) {
            if (take_tree_line() || take_window() || take_table()) {
                understood_ = true;
                continue;
            }
            report_line();
        }
        flush_device();
        if (failed_) parts_.clear();
        if (parts_.empty() && !failed_) reporter_.error("file.csv.no_header", source_.location(0));
        return std::move(parts_);
    }

private:
    struct Line {
        Row row;
        char separator = ',';
        std::size_t next = 0;
    };

    // The offset of the next line that has more than separators.
    [[nodiscard]] std::size_t filled_from(std::size_t at) const {
        const auto filled = std::min(text_.find_first_not_of("\r\n\t ;,", at), text_.size());
        const auto line = text_.rfind('\n', filled);
        return filled == text_.size() ? filled : std::max(at, line == std::string_view::npos ? 0 : line + 1);
    }

    [[nodiscard]] std::string_view line_at(std::size_t at) const {
        return trimmed(text_.substr(at, text_.find('\n', at) - at));
    }

    [[nodiscard]] std::size_t behind_line(std::size_t at) const {
        return std::min(text_.find('\n', at), text_.size() - 1) + 1;
    }

    [[nodiscard]] Line read_line(std::size_t at, char separator) const {
        Reporter unheard;
        RowReader rows(source_, at, separator, unheard);
        auto row = rows.next();
        return {row ? *std::move(row) : Row{.cells = {}, .damaged = true}, separator, rows.offset()};
    }

    // A line as a field of a window; its name may be unknown. Nothing if it is none.
    [[nodiscard]] std::optional<Line> read_field(std::size_t at, char separator) const {
        auto line = read_line(at, separator);
        if (line.row.damaged || !settle_window_line(line.row.cells)) return std::nullopt;
        return line;
    }

    [[nodiscard]] std::optional<Line> read_known_field(std::size_t at) const {
        constexpr std::string_view kCandidates = "\t;\x1f,";
        for (const char separator : kCandidates) {
            if (separator_ != 0 && separator != separator_ && separator != kNoSeparator) continue;
            if (separator != kNoSeparator && !line_at(at).contains(separator)) continue;
            auto line = read_field(at, separator);
            if (line && !read_field_name(line->row.cells[0].text).key.empty()) return line;
        }
        return std::nullopt;
    }

    // The headings of a line, with the separator that makes most of its cells known.
    struct Headings {
        std::size_t known = 0;
        std::size_t filled = 0;
        bool name_and_type = false;
        char separator = ',';
    };

    [[nodiscard]] Headings headings_at(std::size_t at, char separator) const {
        Headings headings{.separator = separator};
        std::set<std::string_view> keys;
        for (const auto& cell : read_line(at, separator).row.cells) {
            const auto key = key_of(cell);
            if (!cell.text.empty()) ++headings.filled;
            if (!key.empty()) ++headings.known;
            keys.insert(key);
        }
        headings.name_and_type = keys.contains("name") && keys.contains("type");
        return headings;
    }

    [[nodiscard]] Headings headings_at(std::size_t at) const {
        if (separator_ != 0) return headings_at(at, separator_);
        auto best = headings_at(at, first_separator(text_.substr(at)));
        for (const char separator : kSeparators)
            if (const auto other = headings_at(at, separator); other.known > best.known) best = other;
        return best;
    }

    [[nodiscard]] bool is_heading_line(std::size_t at) const {
        const auto headings = headings_at(at);
        return headings.known >= 2 && 2 * headings.known > headings.filled &&
               (headings.filled > 2 || headings.name_and_type);
    }

    // Whether another part begins in the middle of the rows of a table. The cells of a window without the
    // name of its device differ from those of rows.
    [[nodiscard]] bool part_begins(std::size_t at, char separator, std::size_t columns) const {
        const auto line = line_at(at);
        const auto [tree, rest] = split_tree(line);
        if (tree && (rest.empty() || device_line(rest))) return true;
        if (device_line(line)) {
            const auto next = filled_from(behind_line(at));
            return !line.contains(separator) && next < text_.size() && part_begins(next, separator, columns);
        }
        if (key_of({.offset = at, .text = std::string(line.substr(0, line.find_first_of(";\t:,")))}).empty())
            return false;
        const auto headings = headings_at(at);
        if (headings.name_and_type && headings.filled > 2 && headings.known == headings.filled) return true;
        Divider here(source_, separator_, reporter_);
        here.at_ = at;
        const auto field = read_known_field(at);
        constexpr std::size_t kFieldCells = 2;
        return field && (key_of(field->row.cells[0]) == "name" || columns > kFieldCells) &&
               here.take_window();
    }

    // The lines that are drawn before a device of a tree: box drawing characters, U+2500 to U+257F.
    static std::string_view without_branches(std::string_view line) {
        constexpr std::size_t kBytes = 3;
        while (line.starts_with("\xE2\x94") || line.starts_with("\xE2\x95"))
            line = trimmed(line.substr(std::min(kBytes, line.size())));
        return line;
    }

    // Whether a line begins with words of a tree, and the part of the line behind them.
    static std::pair<bool, std::string_view> split_tree(std::string_view line) {
        const auto drawn = line.size();
        line = without_branches(line);
        bool tree = line.size() < drawn;
        while (!line.empty()) {
            const auto end = std::min(line.find_first_of(",;\t"), line.size());
            if (!is_tree_word(line.substr(0, end))) break;
            tree = true;
            line = trimmed(line.substr(std::min(end + 1, line.size())));
        }
        return {tree, line};
    }

    // `Устройство, 16` as its name and its address.
    [[nodiscard]] std::optional<std::pair<std::string_view, std::string_view>> device_line(
        std::string_view line) const {
        constexpr std::size_t kDigits = 3;
        const auto comma = line.rfind(',');
        if (comma == std::string_view::npos || line.find_first_of(";\t\"") != std::string_view::npos)
            return std::nullopt;
        const auto name = trimmed(line.substr(0, comma));
        const auto address = trimmed(line.substr(comma + 1));
        const auto key = read_heading(name).key;
        if (name.empty() || name.contains(',') || !all_digits(address) || address.size() > kDigits ||
            (!key.empty() && key != kDeviceColumn))
            return std::nullopt;
        return std::pair(name, address);
    }

    bool take_tree_line() {
        const auto [tree, rest] = split_tree(line_at(at_));
        const auto device = device_line(rest);
        const auto next = behind_line(at_);
        if (!rest.empty() && (!device || !(tree || in_tree_ || stands_above_a_part(next)))) return false;
        if (device) {
            flush_device();
            const auto cell = [&](std::string_view text) {
                return Cell{static_cast<std::size_t>(text.data() - text_.data()), std::string(text), false};
            };
            auto& window = device_.emplace(Part{.window = true, .separator = ',', .names = {}});
            const auto name = cell(device->first);
            const auto address = cell(device->second);
            put(window, {name.offset, "Имя", false}, name);
            put(window, {address.offset, "Адрес", false}, address);
        }
        in_tree_ = true;
        at_ = next;
        return true;
    }

    [[nodiscard]] bool stands_above_a_part(std::size_t at) const {
        const auto next = filled_from(at);
        return next < text_.size() && (is_heading_line(next) || read_known_field(next));
    }

    // The device of a line of the tree that has no window.
    void flush_device() {
        if (device_) parts_.push_back(*std::move(device_));
        device_.reset();
    }

    // The known fields of a window and the offset behind it.
    std::size_t read_window(Part& window, std::set<std::string_view>& known) const {
        constexpr std::array<std::string_view, 3> kValueWords{"значение", "value", "значення"};
        auto end = at_;
        for (auto at = at_; at < text_.size() && window.names.cells.size() < kMaxColumns;) {
            const bool first = window.names.cells.empty();
            auto line = read_known_field(at);
            if (!line && (at == end || first)) line = unknown_field(at, window.separator, first);
            if (!line || (!first && window.separator != ',' && device_line(line_at(at)))) break;
            auto& cells = line->row.cells;
            const auto key = read_field_name(cells[0].text).key;
            const auto value = folded(cells[1].text);
            const bool names = key == "name" || key == kDeviceColumn;
            if (names && (known.contains("name") || known.contains(kDeviceColumn))) break;
            if (first) window.separator = line->separator;
            end = line->next;
            at = filled_from(end);
            if (first && std::ranges::find(kValueWords, value) != kValueWords.end()) continue;
            if (!key.empty()) known.insert(key);
            put(window, std::move(cells[0]), std::move(cells[1]));
        }
        return end;
    }

    // A field with an unknown name stands among the others and has a value.
    [[nodiscard]] std::optional<Line> unknown_field(std::size_t at, char separator, bool first) const {
        if (first) separator = first_separator(text_.substr(at));
        auto line = read_field(at, separator);
        return line && !line->row.cells[0].text.empty() && !line->row.cells[1].text.empty() ? line
                                                                                            : std::nullopt;
    }

    bool take_window() {
        Part window{.window = true, .names = {}};
        std::set<std::string_view> known;
        const auto end = read_window(window, known);
        const std::size_t least = device_ ? 1 : 2;
        if (known.size() < least || 2 * known.size() <= window.names.cells.size() || has_headings(window))
            return false;
        if (device_) complete(window, known);
        parts_.push_back(std::move(window));
        in_tree_ = false;
        at_ = end;
        return true;
    }

    // Adds name and address of the line of the tree above a window, also in the place of empty ones.
    void complete(Part& window, const std::set<std::string_view>& known) {
        const auto device = *std::exchange(device_, std::nullopt);
        for (std::size_t i = 0; i < device.names.cells.size(); ++i) {
            const auto& name = device.names.cells[i];
            const auto& value = device.values.cells[i];
            const auto key = key_of(name);
            if (!known.contains(key)) {
                put(window, name, value);
                continue;
            }
            for (std::size_t j = 0; j < window.names.cells.size(); ++j)
                if (auto& own = window.values.cells[j]; key_of(window.names.cells[j]) != key) {
                    continue;
                } else if (own.text.empty()) {
                    own = value;
                } else if (own.text != value.text) {
                    reporter_.error("file.csv.tree_differs", source_.location(value.offset),
                                    {.value = value.text, .arguments = {{"window", own.text}}});
                    failed_ = true;
                }
        }
    }

    // The first line that belongs to no part is read as headings, so that the findings name its columns.
    bool take_table() {
        const bool first = parts_.empty() && !device_ && !in_tree_ && !failed_;
        if (!first && !is_heading_line(at_)) return false;
        const auto separator = headings_at(at_).separator;
        RowReader rows(source_, at_, separator, reporter_);
        auto header = rows.next_filled();
        flush_device();
        if (!header) {
            at_ = text_.size();
            return true;
        }
        Part table{.separator = separator, .names = *std::move(header), .begin = rows.offset()};
        Reporter unheard;
        RowReader body(source_, table.begin, separator, unheard);
        const auto columns = headings_at(at_).filled;
        while (body.offset() < text_.size() && !part_begins(body.offset(), separator, columns)) body.next();
        table.end = at_ = body.offset();
        parts_.push_back(std::move(table));
        in_tree_ = false;
        return true;
    }

    // Reports the first one of several lines.
    void report_line() {
        const auto line = line_at(at_);
        if (understood_) {
            const auto offset = static_cast<std::size_t>(line.data() - text_.data());
            reporter_.error("file.csv.not_understood", source_.location(offset),
                            {.value = std::string(line)});
        }
        failed_ = true;
        understood_ = false;
        at_ = behind_line(at_);
    }

    const Source& source_;
    std::string_view text_;
    char separator_;
    Reporter& reporter_;
    std::size_t at_ = 0;
    std::vector<Part> parts_;
    std::optional<Part> device_;  // of a line of the tree
    bool in_tree_ = false;        // the line above is of the tree
    bool understood_ = true;
    bool failed_ = false;
};

}  // namespace

std::vector<Part> divide(const Source& source, char separator, Reporter& reporter) {
    return Divider(source, separator, reporter).divide();
}

}  // namespace takt::file
