// Cells are translated in two passes. settle_cell() uses only the column and the text. settle_row() uses the
// other cells of the row: default value by type, type by number of registers. settle_addresses() then decides
// for the whole table whether its numbers are addresses or references.
#include "tables/dialect.hpp"

#include <algorithm>
#include <utility>

#include "tables/cell_words.hpp"
#include "tables/headings.hpp"
#include "takt/base/ascii.hpp"
#include "takt/base/utf8.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/notation.hpp"
#include "takt/model/scalar.hpp"
#include "yaml/nodes.hpp"

namespace takt::file {
namespace {

using model::Kind;
using model::Node;

void erase_cell(Node& row, std::string_view key) {
    std::erase_if(row.entries, [&](const Node::Entry& entry) { return entry.key.text == key; });
}

void append_cell(Node& row, std::string_view key, std::string_view text,
                 const model::SourceLocation& location) {
    Node name{.kind = Node::Kind::scalar, .location = location, .text = std::string(key)};
    Node cell{.kind = Node::Kind::scalar, .location = location, .text = std::string(text)};
    row.entries.emplace_back(std::move(name), std::move(cell));
}

void replace_text(Node& cell, std::optional<std::string> word) {
    if (word) cell.text = *std::move(word);
}

bool may_be_dashed(Kind kind) {
    switch (kind) {
        case Kind::integer:
        case Kind::duration:
        case Kind::number:
        case Kind::word:
        case Kind::local_bool:
        case Kind::local_integer:
        case Kind::reference: return true;
        default: return false;
    }
}

bool is_numeric(Kind kind) {
    return kind == Kind::integer || kind == Kind::duration || kind == Kind::number || kind == Kind::reference;
}

// Joins the lines of a cell: spreadsheets allow line breaks in a comment, a project file does not.
std::string in_one_line(std::string_view text) {
    std::string line;
    for (std::size_t at = 0; at < text.size(); ++at) {
        if (text[at] != '\r' && text[at] != '\n')
            line += text[at];
        else if (!line.ends_with(' ') && !line.empty())
            line += ' ';
    }
    return line;
}

void settle_registers(Node& row, Reporter& reporter) {
    auto* const type = find_value(row, "type");
    const auto* const count = row.find(kRegistersColumn);
    if (count == nullptr) return;
    const auto number = model::parse_integer(count->text);
    const auto registers = number && number->magnitude <= 125 ? static_cast<int>(number->magnitude) : 0;
    if (type != nullptr && type->text == "string" && registers > 0 && row.find("length") == nullptr) {
        auto length = *count;
        auto key = Node(length);
        key.text = "length";
        row.entries.emplace_back(std::move(key), std::move(length));
    } else if (type != nullptr && type->text != "string") {
        const bool known = std::ranges::find(model::kTypes, type->text) != model::kTypes.end();
        const auto sized = type_of_registers(type->text, registers);
        if (sized)
            type->text = *sized;
        else if (known)
            reporter.error("file.csv.register_count", count->location,
                           {.value = count->text, .arguments = {{"type", type->text}}});
    }
    erase_cell(row, kRegistersColumn);
}

// Tables of an IDE show bit 0 also for variables that are no bits.
void settle_bit(Node& row) {
    const auto type = text_of(row, "type");
    const bool other = type != "bool" && std::ranges::find(model::kTypes, type) != model::kTypes.end();
    if (other && text_of(row, "bit") == "0") erase_cell(row, "bit");
}

void settle_default(Node& row, bool decimal_comma) {
    auto* const cell = find_value(row, "default");
    if (cell == nullptr) return;
    const auto type = text_of(row, "type");
    if (type == "string") return;
    if (means_nothing(cell->text) && type != "bool") return erase_cell(row, "default");
    if (type == "bool")
        return replace_text(*cell,
                            cell->text == "0" || cell->text == "1" ? std::nullopt : boolean_word(cell->text));
    replace_text(*cell, ungrouped_word(cell->text));
    if (decimal_comma) replace_text(*cell, number_word(cell->text));
}

// The first digit of the references in a row's area; 0 if the row does not name its area.
char area_digit(const Node& row) {
    const auto area = text_of(row, "area");
    for (std::size_t i = 0; i < model::kAreas.size(); ++i)
        if (area == model::kAreas[i]) return "0134"[i];
    for (const std::string_view key : {"read", "write"}) {
        const auto number = model::parse_integer(text_of(row, key));
        if (!number) continue;
        switch (number->magnitude) {
            case 1:
            case 5:
            case 15: return '0';
            case 2: return '1';
            case 3:
            case 6:
            case 16: return '4';
            case 4: return '3';
            default: break;
        }
    }
    return 0;
}

// A register number is taken for a reference if it has five or six digits and the first one fits the area.
bool may_be_reference(const Node& row, std::string_view text) {
    if (!looks_like_reference(text)) return false;
    const auto digit = area_digit(row);
    const bool bits = text[0] == '0' || text[0] == '1';
    return (digit == 0 || digit == text[0]) && !(bits && row.find("bit") != nullptr);
}

// `108` in the area of function 0x03 is 40108: spreadsheets drop the area digit and leading zeros.
void make_reference(Node& row) {
    const auto digit = area_digit(row);
    for (auto& [key, cell] : row.entries)
        if (key.text == "register") {
            key.text = "reference";
            if (auto word = reference_word(cell.text)) {
                if (digit != 0) word->front() = digit;
                cell.text = *std::move(word);
            }
        }
}

// `00001` for `20001`, or for `20000` of the zero-based notation.
std::string standard_reference(const std::string& text, Notation notation) {
    auto standard = text;
    if (notation == Notation::standard) return standard;
    if (standard[0] == '2') standard[0] = '0';
    if (notation != Notation::zero_based) return standard;
    const auto next = std::to_string(std::stoul(standard.substr(1)) + 1);
    const auto digits = std::max(standard.size() - 1, next.size());
    return standard.substr(0, 1) + std::string(digits - next.size(), '0') + next;
}

// Five or six digits: that of the area and the number.
bool is_reference(std::string_view text, Notation notation) {
    constexpr unsigned long kItems = 65536;
    if ((text.size() != 5 && text.size() != 6) || !all_digits(text)) return false;
    const std::string_view areas = notation == Notation::standard ? "0134" : "01234";
    const auto number = std::stoul(std::string(text.substr(1)));
    const auto first = notation == Notation::zero_based ? 0UL : 1UL;
    return areas.contains(text[0]) && number >= first && number < first + kItems;
}

// What is_reference() accepts, in words.
std::string_view references(Notation notation) {
    switch (notation) {
        case Notation::standard:
            return "00001..09999, 10001..19999, 30001..39999, 40001..49999; 000001..065536, 100001..165536, "
                   "300001..365536, 400001..465536";
        case Notation::coils_at_20001:
            return "20001..29999, 10001..19999, 30001..39999, 40001..49999; 200001..265536, 100001..165536, "
                   "300001..365536, 400001..465536";
        case Notation::zero_based:
            return "00000..09999, 20000..29999, 10000..19999, 30000..39999, 40000..49999; 000000..065535, "
                   "200000..265535, 100000..165535, 300000..365535, 400000..465535";
    }
    return {};
}

// Makes the number of a row a reference in the standard notation. Returns false, after a report, if it is
// none.
bool take_reference(Node& row, Notation notation, Reporter& reporter) {
    const auto* const register_cell = row.find("register");
    const auto* const typed_cell = register_cell != nullptr ? register_cell : row.find("reference");
    if (typed_cell == nullptr) return true;
    const auto typed = *typed_cell;
    const auto digit = area_digit(row);
    if (register_cell != nullptr) make_reference(row);
    auto* const reference = find_value(row, "reference");
    // The interpretation checks a column of references in the standard notation.
    const bool checked_later = register_cell == nullptr && notation == Notation::standard;
    if (!checked_later && !is_reference(reference->text, notation)) {
        reporter.error("file.csv.not_in_notation", typed.location,
                       {.value = typed.text,
                        .allowed = std::string(references(notation)),
                        .arguments = {{"notation",
                                       std::string(model::kNotations[static_cast<std::size_t>(notation)])}}});
        return false;
    }
    if (!checked_later) reference->text = standard_reference(reference->text, notation);
    const bool bits = reference->text.starts_with('0') || reference->text.starts_with('1');
    if (notation != Notation::standard && bits && text_of(row, "bit") == "0")
        erase_cell(row, "bit");  // the number already is that of a bit
    if (digit != 0 && reference->text.starts_with(digit))
        erase_cell(row, "area");  // the reference already gives the area
    return true;
}

// Whether a number is written as a reference that names its area.
bool names_its_area(std::string_view number) {
    return all_digits(number) && (number.size() == 5 || number.size() == 6);
}

// Makes numbers of another notation references. Other texts stay.
bool settle_notation(Node& row, Notation notation, Reporter& reporter) {
    const auto number = text_of(row, "register");
    const bool is_number = all_digits(number) && (area_digit(row) != 0 || names_its_area(number));
    if (row.find("register") != nullptr && !is_number) return true;
    return take_reference(row, notation, reporter);
}

// Whether a row says that it has no traffic, so that its functions give no area. In a table with columns for
// both functions, empty cells say so too.
bool has_no_traffic(const Node& row, bool functions) {
    const auto none = [&](std::string_view key) { return text_of(row, key) == "none"; };
    const auto missing = [&](std::string_view key) { return row.find(key) == nullptr; };
    if (!functions && missing("read") && missing("write")) return false;
    return (none("read") || missing("read")) && (none("write") || missing("write"));
}

// Gives rows without area that of their type: all of them, or those without traffic. Returns the first one
// that got it.
const Node* assume_areas(Node& list, TableShape shape, bool also_references) {
    const Node* first = nullptr;
    for (auto& row : list.items) {
        const auto* const number = row.find("register");
        if (number == nullptr || row.find("type") == nullptr || row.find("area") != nullptr) continue;
        if (!shape.unaddressed && !has_no_traffic(row, shape.functions)) continue;
        if (!also_references && names_its_area(number->text)) continue;
        const auto location = number->location;
        append_cell(row, "area", text_of(row, "type") == "bool" ? "coil" : "holding_register", location);
        if (!shape.unaddressed && row.find("read") == nullptr) append_cell(row, "read", "none", location);
        if (first == nullptr) first = &row;
    }
    return first;
}

struct Count {
    std::size_t references = 0;
    std::size_t numbers = 0;
    const Node* first = nullptr;  // cell that looks like a reference
};

Count count_references(const Node& list) {
    Count count;
    for (const auto& row : list.items) {
        const auto* const cell = row.find("register");
        if (cell == nullptr) continue;
        ++count.numbers;
        if (!may_be_reference(row, cell->text)) continue;
        ++count.references;
        if (count.first == nullptr) count.first = cell;
    }
    return count;
}

// Whether the numbers of a table are references in the standard notation. The interpretation reports
// addresses that look like references.
bool are_references(const Node& list, Addresses addresses, Reporter& reporter) {
    if (addresses != Addresses::automatic) return addresses == Addresses::reference;
    const auto count = count_references(list);
    if (count.references == 0 || count.references < count.numbers) return false;
    reporter.warning(
        "file.csv.taken_as_references", count.first->location,
        {.value = count.first->text, .arguments = {{"count", std::to_string(count.references)}}});
    return true;
}

}  // namespace

bool settle_cell(const Column& column, Node& cell, bool decimal_comma) {
    const auto* const field = column_field(column.key.text);
    if (is_placeholder(cell.text)) {
        if (field == nullptr || field->kind != Kind::function) return false;
        cell.text = "none";
        return true;
    }
    if (field == nullptr) return true;
    if (may_be_dashed(field->kind) && field->key != "type" && means_nothing(cell.text)) return false;
    if (is_numeric(field->kind)) replace_text(cell, ungrouped_word(cell.text));
    switch (field->kind) {
        case Kind::integer: replace_text(cell, address_word(cell.text, column.hexadecimal)); break;
        case Kind::duration: replace_text(cell, duration_word(cell.text, column.unit, decimal_comma)); break;
        case Kind::boolean: replace_text(cell, boolean_word(cell.text)); break;
        case Kind::function: replace_text(cell, function_word(cell.text)); break;
        case Kind::reference: replace_text(cell, reference_word(cell.text)); break;
        case Kind::number:
            if (decimal_comma) replace_text(cell, number_word(cell.text));
            break;
        case Kind::word:
            replace_text(cell, field->key == "type"         ? type_word(cell.text)
                               : field->key == "byte_order" ? byte_order_word(cell.text)
                                                            : area_word(cell.text));
            break;
        case Kind::text:
            if (field->key == "comment") cell.text = in_one_line(cell.text);
            break;
        default: break;
    }
    return true;
}

void settle_row(Node& row, bool decimal_comma, Reporter& reporter) {
    settle_bit(row);
    settle_registers(row, reporter);
    settle_default(row, decimal_comma);
}

std::optional<Node> read_row(std::span<const std::pair<std::string, std::string>> cells) {
    Node row{.kind = Node::Kind::mapping};
    for (const auto& [key, text] : cells) {
        if (key == "name" && is_placeholder(text)) return std::nullopt;
        if (text.empty()) continue;
        append_cell(row, key, text, {});
        if (!settle_cell({.key = {.text = key}, .unit = "ms"}, row.entries.back().value, true))
            row.entries.pop_back();
    }
    Reporter unheard;
    settle_row(row, true, unheard);
    return row;
}

void settle_addresses(Node& list, const TableOptions& options, TableShape shape, Reporter& reporter) {
    const auto* const first = assume_areas(list, shape, false);
    auto assumed = first == nullptr ? std::nullopt : std::optional(first->location);
    const bool other_notation = options.notation != Notation::standard;
    if (other_notation || are_references(list, options.addresses, reporter))
        std::erase_if(list.items, [&](Node& row) {
            return !(other_notation ? settle_notation(row, options.notation, reporter)
                                    : take_reference(row, options.notation, reporter));
        });
    const auto* const further = assume_areas(list, shape, true);
    if (further != nullptr && !assumed) assumed = further->location;
    if (assumed && shape.unaddressed) reporter.warning("file.csv.area_assumed", *assumed);
}

std::pair<std::string, std::string> as_comment(std::string_view text) {
    constexpr std::size_t kMostCharacters = 1000;
    const auto line = in_one_line(text);
    std::size_t at = 0;
    for (std::size_t count = 0; at < line.size(); ++count) {
        if (count == kMostCharacters - 1 && count_characters(line) > kMostCharacters)
            return {line.substr(0, at) + "…", line.substr(at)};
        at += std::max<std::size_t>(first_character(std::string_view(line).substr(at)).bytes, 1);
    }
    return {line, {}};
}

bool looks_like_reference(std::string_view text) {
    if ((text.size() != 5 && text.size() != 6) || !all_digits(text)) return false;
    return std::string_view("0134").contains(text[0]) &&
           text.find_first_not_of('0', 1) != std::string_view::npos;
}

}  // namespace takt::file
