#include "yaml/yaml_layout.hpp"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>

#include "yaml/source.hpp"

namespace takt::file {
using Style = Layout::Style;

namespace {

using model::Node;

/// The text does not have the expected token.
struct Mismatch {};

bool is_blank(char c) {
    return c == ' ' || c == '\t';
}

bool is_space(char c) {
    return is_blank(c) || c == '\r' || c == '\n';
}

class Scanner {
public:
    explicit Scanner(std::string_view text) : text_(text) {}

    Layout root(const Node& node) {
        if (text_.starts_with(kByteOrderMark)) at_ = kByteOrderMark.size();
        skip_head();
        auto layout = value(node, Around{});
        skip_trivia();
        const bool marked = text_.substr(at_).starts_with("...") || text_.substr(at_).starts_with("---");
        if (at_ < text_.size() && !marked) throw Mismatch{};
        return layout;
    }

private:
    /// The collection around a node.
    struct Around {
        bool flow = false;
        std::ptrdiff_t column = -1;  // of the innermost block collection
    };

    [[nodiscard]] char peek(std::size_t ahead = 0) const {
        return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0';
    }
    [[nodiscard]] std::size_t column(std::size_t offset) const { return offset - line_begin(text_, offset); }
    [[nodiscard]] bool ends_token(std::size_t offset) const {
        return offset >= text_.size() || is_space(text_[offset]);
    }

    void expect(char c) {
        if (peek() != c || at_ >= text_.size()) throw Mismatch{};
        ++at_;
    }
    void skip_blanks() {
        while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
    }
    void skip_line() { at_ = line_end(text_, at_); }

    // White space, line breaks and comments.
    void skip_trivia() {
        while (at_ < text_.size()) {
            if (is_space(text_[at_]))
                ++at_;
            else if (text_[at_] == '#' && begins_comment())
                skip_line();
            else
                return;
        }
    }
    // A comment is separated by white space; it may follow a bracket or comma directly.
    [[nodiscard]] bool begins_comment() const {
        return at_ == 0 || is_space(text_[at_ - 1]) || std::string_view(",[]{}").contains(text_[at_ - 1]) ||
               column(at_) == 0;
    }

    // Directives and the mark of the document's beginning.
    void skip_head() {
        while (true) {
            skip_trivia();
            if (peek() == '%' && column(at_) == 0) {
                skip_line();
            } else if (text_.substr(at_).starts_with("---") && ends_token(at_ + 3)) {
                at_ += 3;
                return;
            } else {
                return;
            }
        }
    }

    Layout value(const Node& node, const Around& around) {
        if (node.kind == Node::Kind::null) return null_value(node, around);
        skip_trivia();
        Layout layout{.node = &node, .begin = at_, .end = at_};
        if (node.kind == Node::Kind::scalar) {
            scalar(layout, around);
        } else if (node.kind == Node::Kind::list) {
            peek() == '[' ? flow_list(layout) : block_list(layout, around);
        } else if (peek() == '{') {
            flow_mapping(layout);
        } else if (around.flow) {
            pair(layout);
        } else {
            block_mapping(layout);
        }
        return layout;
    }

    // The length of a null that is written at `offset`, or 0.
    [[nodiscard]] std::size_t null_at(std::size_t offset, bool flow) const {
        const auto rest = text_.substr(offset);
        for (const auto word : kNullWords) {
            if (!rest.starts_with(word)) continue;
            const auto end = offset + word.size();
            const bool in_flow = flow && end < text_.size() && std::string_view(",]}").contains(text_[end]);
            if (ends_token(end) || in_flow) return word.size();
        }
        return 0;
    }

    Layout null_value(const Node& node, const Around& around) {
        Layout layout{.node = &node, .begin = at_, .end = at_};
        const auto behind = at_;
        skip_trivia();
        const bool same_line = !text_.substr(behind, at_ - behind).contains('\n');
        const bool inside =
            around.flow || same_line || static_cast<std::ptrdiff_t>(column(at_)) > around.column;
        const auto length = inside && at_ < text_.size() ? null_at(at_, around.flow) : 0;
        if (length == 0) {
            at_ = behind;
            return layout;
        }
        layout.style = Style::plain;
        layout.begin = at_;
        layout.end = at_ += length;
        return layout;
    }

    void scalar(Layout& layout, const Around& around) {
        const char first = peek();
        if (first == '"' || first == '\'') {
            layout.style = first == '"' ? Style::double_quoted : Style::single_quoted;
            quoted(first);
        } else if (!around.flow && (first == '|' || first == '>')) {
            layout.style = Style::block_scalar;
            block_scalar(layout, around);
        } else {
            layout.style = Style::plain;
            plain(layout.node->text);
        }
        layout.end = at_;
    }

    void quoted(char quote) {
        for (++at_; at_ < text_.size(); ++at_) {
            if (quote == '"' && text_[at_] == '\\') {
                ++at_;
            } else if (text_[at_] == quote) {
                if (quote == '"' || peek(1) != quote) {
                    ++at_;
                    return;
                }
                ++at_;
            }
        }
        throw Mismatch{};
    }

    // Follows the words of the text: a line break is read as a space, n of them as n - 1 line breaks.
    void plain(std::string_view words) {
        if (words.empty()) throw Mismatch{};
        while (!words.empty()) {
            if (is_space(words[0])) {
                const auto folded = white_space();
                if (folded.empty() || !words.starts_with(folded)) throw Mismatch{};
                words.remove_prefix(folded.size());
            } else {
                expect(words[0]);
                words.remove_prefix(1);
            }
        }
    }

    // The meaning of the white space inside a plain scalar.
    std::string white_space() {
        const auto begin = at_;
        std::size_t breaks = 0;
        for (; at_ < text_.size() && is_space(text_[at_]); ++at_)
            if (text_[at_] == '\n') ++breaks;
        if (breaks == 0) return std::string(text_.substr(begin, at_ - begin));
        return breaks == 1 ? " " : std::string(breaks - 1, '\n');
    }

    // Ends behind the last line that is not blank; with `+` behind the blank lines that follow.
    void block_scalar(Layout& layout, const Around& around) {
        const auto header = text_.substr(at_, line_end(text_, at_) - at_);
        const auto marks = header.substr(0, header.find_first_of(" \t\r\n#"));
        const auto digit = marks.find_first_of("123456789");
        const bool keep = marks.contains('+');
        std::size_t least = static_cast<std::size_t>(around.column + 1);
        bool known = digit != std::string_view::npos;
        if (known)
            least = static_cast<std::size_t>(std::max<std::ptrdiff_t>(around.column, 0) + marks[digit] - '0');
        skip_line();
        auto end = without_break(at_);
        while (at_ < text_.size()) {
            const auto line = text_.substr(at_, line_end(text_, at_) - at_);
            const auto indent = std::min(line.find_first_not_of(' '), line.size());
            const bool blank = line.find_first_not_of(" \r\n") == std::string_view::npos;
            if (!blank && indent < least) break;
            if (!blank && !std::exchange(known, true)) least = indent;
            skip_line();
            if (!blank || keep) end = without_break(at_);
        }
        layout.column = least;
        at_ = end;
    }

    [[nodiscard]] std::size_t without_break(std::size_t offset) const {
        if (offset > 0 && text_[offset - 1] == '\n') --offset;
        if (offset > 0 && text_[offset - 1] == '\r') --offset;
        return offset;
    }

    void block_list(Layout& layout, const Around& around) {
        if (around.flow) throw Mismatch{};
        layout.style = Style::block;
        layout.column = column(at_);
        for (const auto& item : layout.node->items) {
            skip_trivia();
            LayoutPart part{.begin = at_};
            expect('-');
            if (!ends_token(at_)) throw Mismatch{};
            part.indicator_end = at_;
            finish_block_part(layout, std::move(part), item);
        }
        layout.end = at_;
    }

    void block_mapping(Layout& layout) {
        layout.style = Style::block;
        layout.column = column(at_);
        for (const auto& [key, item] : layout.node->entries) {
            skip_trivia();
            LayoutPart part{.begin = at_};
            const bool marked = key_mark();
            key_text(key, false);
            if (marked)
                skip_trivia();
            else
                skip_blanks();
            expect(':');
            part.indicator_end = at_;
            finish_block_part(layout, std::move(part), item);
        }
        layout.end = at_;
    }

    // The mark of an explicit key.
    bool key_mark() {
        if (peek() != '?' || !ends_token(at_ + 1)) return false;
        ++at_;
        skip_trivia();
        return true;
    }

    void key_text(const Node& key, bool flow) {
        if (key.kind != Node::Kind::scalar) throw Mismatch{};
        Layout ignored{.node = &key, .begin = at_};
        scalar(ignored, Around{.flow = flow});
    }

    void finish_block_part(Layout& layout, LayoutPart part, const Node& item) {
        part.value = value(item, Around{.column = static_cast<std::ptrdiff_t>(layout.column)});
        if (part.value.style != Style::block) finish_line();
        skip_deeper_comments(layout.column);
        part.end = at_;
        layout.parts.push_back(std::move(part));
    }

    void finish_line() {
        skip_blanks();
        if (peek() == '#' || peek() == '\r' || peek() == '\n')
            skip_line();
        else if (at_ < text_.size())
            throw Mismatch{};
    }

    // Comment lines below a part, indented more than it, belong to it.
    void skip_deeper_comments(std::size_t outer) {
        while (at_ < text_.size()) {
            const auto comment = text_.find_first_not_of(" \t", at_);
            if (comment == std::string_view::npos || text_[comment] != '#' || comment - at_ <= outer) return;
            skip_line();
        }
    }

    void flow_list(Layout& layout) {
        layout.style = Style::flow;
        expect('[');
        for (const auto& item : layout.node->items) {
            skip_trivia();
            LayoutPart part{.begin = at_, .indicator_end = at_};
            finish_flow_part(layout, std::move(part), item);
        }
        skip_trivia();
        expect(']');
        layout.end = at_;
    }

    void flow_mapping(Layout& layout) {
        layout.style = Style::flow;
        expect('{');
        for (const auto& [key, item] : layout.node->entries) {
            skip_trivia();
            flow_entry(layout, key, item);
        }
        skip_trivia();
        expect('}');
        layout.end = at_;
    }

    void flow_entry(Layout& layout, const Node& key, const Node& item) {
        LayoutPart part{.begin = at_};
        (void)key_mark();
        key_text(key, true);
        const auto behind = at_;
        skip_trivia();
        if (peek() == ':')
            ++at_;
        else
            at_ = behind;
        part.indicator_end = at_;
        finish_flow_part(layout, std::move(part), item);
    }

    void finish_flow_part(Layout& layout, LayoutPart part, const Node& item) {
        part.value = value(item, Around{.flow = true});
        part.end = at_;
        if (layout.style == Style::flow) {
            const auto behind = at_;
            skip_trivia();
            if (peek() == ',')
                part.comma = at_++;
            else
                at_ = behind;
        }
        layout.parts.push_back(std::move(part));
    }

    void pair(Layout& layout) {
        if (layout.node->entries.size() != 1) throw Mismatch{};
        layout.style = Style::pair;
        flow_entry(layout, layout.node->entries[0].key, layout.node->entries[0].value);
        layout.end = at_;
    }

    std::string_view text_;
    std::size_t at_ = 0;
};

}  // namespace

std::optional<Layout> lay_out(std::string_view text, const Node& root) {
    try {
        return Scanner(text).root(root);
    } catch (const Mismatch&) {
        return std::nullopt;
    }
}

std::size_t line_begin(std::string_view text, std::size_t offset) {
    const auto before = text.substr(0, offset).rfind('\n');
    if (before != std::string_view::npos) return before + 1;
    return text.starts_with(kByteOrderMark) ? std::min(kByteOrderMark.size(), offset) : 0;
}

std::size_t line_end(std::string_view text, std::size_t offset) {
    const auto found = text.find('\n', offset);
    return found == std::string_view::npos ? text.size() : found + 1;
}

}  // namespace takt::file
