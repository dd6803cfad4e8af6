// The contents of a plain scalar: YAML 1.2, section 7.3.3, and yaml-cpp, which also ends one inside brackets
// at a question mark.
#include "yaml/yaml_scalar.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace takt::file {
using Style = Layout::Style;

namespace {

using model::Kind;

bool is_control(char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7F;
}

bool fits_plain(std::string_view text, bool flow) {
    if (text.empty() || text.front() == ' ' || text.back() == ' ' || text.back() == ':') return false;
    if (std::string_view("?:,[]{}#&*!|>'\"%@`").contains(text[0])) return false;
    if (text[0] == '-' && (text.size() == 1 || text[1] == ' ')) return false;
    if (text.starts_with("---") || text.starts_with("...") || text == "<<" || text == "=") return false;
    if (std::ranges::find(kNullWords, text) != kNullWords.end()) return false;
    if (std::ranges::any_of(text, is_control)) return false;
    if (text.contains(": ") || text.contains(" #")) return false;
    return !flow || text.find_first_of(",?[]{}") == std::string_view::npos;
}

// Whether another reader could take the text for a number, a time or a boolean.
bool looks_typed(std::string_view text) {
    std::string small(text);
    for (char& c : small)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + 0x20);
    if (std::ranges::find(kBooleanWords, small) != kBooleanWords.end()) return true;
    const bool begins = !text.empty() && std::string_view("0123456789+-.").contains(text[0]);
    return begins && small.find_first_not_of("0123456789abcdefxot_.:+- ") == std::string::npos;
}

std::string double_quoted(std::string_view text) {
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\')
            result.append(1, '\\').append(1, c);
        else if (c == '\n')
            result += "\\n";
        else if (c == '\t')
            result += "\\t";
        else if (is_control(c))
            result += fmt::format("\\x{:02X}", static_cast<unsigned char>(c));
        else
            result += c;
    }
    return result + '"';
}

std::string single_quoted(std::string_view text) {
    std::string result = "'";
    for (const char c : text) result.append(c == '\'' ? 2 : 1, c);
    return result + '\'';
}

/// The lines of a text that ends with a line break or not.
std::vector<std::string_view> lines_of(std::string_view text) {
    std::vector<std::string_view> lines;
    while (!text.empty()) {
        const auto end = std::min(text.find('\n'), text.size());
        lines.push_back(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return lines;
}

/// Whether lines can be those of a block scalar without an indentation mark.
bool fits_block(std::string_view text, const std::vector<std::string_view>& lines, bool folded) {
    if (lines.empty() || lines.front().empty() || lines.back().empty() || text.ends_with("\n\n"))
        return false;
    return std::ranges::all_of(lines, [&](std::string_view line) {
        const bool indented = line.starts_with(' ') || line.starts_with('\t');
        return std::ranges::none_of(line, is_control) && !line.ends_with(' ') && !(folded && indented) &&
               !(indented && line.data() == text.data());
    });
}

/// The header stays, so its mark for the last line break must fit the text.
std::optional<std::string> block_scalar(std::string_view text, const Layout& replaced,
                                        std::string_view file_text, std::string_view line_break) {
    const auto old = file_text.substr(replaced.begin, replaced.end - replaced.begin);
    const auto header = old.substr(0, old.find_first_of("\r\n"));
    const auto marks = header.substr(0, header.find_first_of(" \t#"));
    const bool folded = marks[0] == '>';
    const auto lines = lines_of(text);
    if (marks.size() > 2 || marks.contains('+') || !fits_block(text, lines, folded)) return std::nullopt;
    if (marks.size() == 2 && marks[1] != '-') return std::nullopt;
    if ((marks.size() == 2) == text.ends_with('\n')) return std::nullopt;
    std::string result(header);
    bool first = true;
    for (const auto line : lines) {
        const bool apart = folded && !first && !line.empty();
        first = false;
        if (apart) result += line_break;
        result += line_break;
        if (!line.empty()) result.append(replaced.column, ' ').append(line);
    }
    return result;
}

}  // namespace

ScalarUse use_of(std::optional<model::Object> object, const model::Node& owner, std::string_view key) {
    const auto* const field = object ? model::find_field(*object, key) : nullptr;
    if (field == nullptr) return ScalarUse::any;
    const auto* const type = owner.find("type");
    switch (field->kind) {
        case Kind::text:
        case Kind::words:
        case Kind::local_bool:
        case Kind::local_integer: return ScalarUse::text;
        case Kind::reference: return ScalarUse::digits;
        case Kind::word: return key == "byte_order" ? ScalarUse::digits : ScalarUse::any;
        case Kind::constant:
            return type != nullptr && type->text == "string" ? ScalarUse::text : ScalarUse::number;
        case Kind::list:
        case Kind::mapping:
        case Kind::ranges: return ScalarUse::any;
        default: return ScalarUse::number;
    }
}

std::string scalar_text(std::string_view text, ScalarUse use, bool flow) {
    const bool quotes = use == ScalarUse::digits || (use == ScalarUse::text && looks_typed(text));
    return !quotes && fits_plain(text, flow) ? std::string(text) : double_quoted(text);
}

std::string scalar_text_like(std::string_view text, ScalarUse use, bool flow, const Layout& replaced,
                             std::string_view file_text, std::string_view line_break) {
    if (use == ScalarUse::number) return scalar_text(text, use, flow);
    if (replaced.style == Style::double_quoted) return double_quoted(text);
    if (replaced.style == Style::single_quoted && std::ranges::none_of(text, is_control))
        return single_quoted(text);
    if (replaced.style == Style::block_scalar)
        if (auto block = block_scalar(text, replaced, file_text, line_break)) return *std::move(block);
    return scalar_text(text, use, flow);
}

}  // namespace takt::file
