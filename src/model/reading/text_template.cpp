// Parses a template into literals and placeholders, left to right. Adjacent literals are merged. Two adjacent
// placeholders are an error, because nothing marks the end of the first one.
#include "takt/model/text_template.hpp"

#include <algorithm>
#include <optional>

#include "takt/base/ascii.hpp"

namespace takt::model {
namespace {

bool is_letter(char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_';
}

bool is_name(std::string_view text) {
    return !text.empty() && is_letter(text[0]) &&
           std::ranges::all_of(text, [](char c) { return is_letter(c) || (c >= '0' && c <= '9'); });
}

class Parser {
public:
    Parser(std::string_view text, bool placeholders) : text_(text), placeholders_(placeholders) {}

    std::expected<TextTemplate, TemplateError> run() {
        if (text_.size() > kMostTemplateBytes) return error(kMostTemplateBytes);
        while (at_ < text_.size()) {
            const std::size_t begin = at_;
            if (!take() || result_.pieces.size() > kMostTemplatePieces) return error(begin);
        }
        return std::move(result_);
    }

private:
    static std::unexpected<TemplateError> error(std::size_t at) {
        return std::unexpected(TemplateError{at + 1});
    }

    bool take() {
        const char c = text_[at_++];
        if (c == '\\') return take_escape();
        if (placeholders_ && c == '{') return take_placeholder();
        if (placeholders_ && c == '}') return false;
        put(c);
        return true;
    }

    void put(char c) {
        if (result_.pieces.empty() || result_.pieces.back().kind != TextTemplate::Kind::literal)
            result_.pieces.push_back({});
        result_.pieces.back().text += c;
    }

    bool take_escape() {
        if (at_ == text_.size()) return false;
        constexpr std::string_view kWritten = "rnt0\\{}";
        constexpr std::string_view kMeant{"\r\n\t\0\\{}", 7};
        const char c = text_[at_++];
        if (const auto index = kWritten.find(c); index != std::string_view::npos) {
            put(kMeant[index]);
            return true;
        }
        if (c != 'x' || text_.size() - at_ < 2) return false;
        const auto high = hex_value(text_[at_]);
        const auto low = hex_value(text_[at_ + 1]);
        if (!high || !low) return false;
        at_ += 2;
        put(static_cast<char>(*high << 4 | *low));
        return true;
    }

    bool take_placeholder() {
        const auto end = text_.find('}', at_);
        if (end == std::string_view::npos) return false;
        const auto inside = text_.substr(at_, end - at_);
        at_ = end + 1;
        const auto colon = inside.find(':');
        const auto name = inside.substr(0, colon);
        const auto kind =
            kind_of(name, colon == std::string_view::npos ? std::string_view() : inside.substr(colon));
        if (!kind || endless() || (*kind != TextTemplate::Kind::skip && result_.has(name))) return false;
        result_.pieces.push_back(
            {*kind, *kind == TextTemplate::Kind::skip ? std::string() : std::string(name)});
        return true;
    }

    static std::optional<TextTemplate::Kind> kind_of(std::string_view name, std::string_view suffix) {
        using Kind = TextTemplate::Kind;
        if (name == "*" && suffix.empty()) return Kind::skip;
        if (!is_name(name)) return std::nullopt;
        if (suffix.empty()) return Kind::number;
        if (suffix == ":hex") return Kind::hex;
        if (suffix == ":text") return Kind::text;
        return std::nullopt;
    }

    /// Two adjacent placeholders: nothing marks the end of the first one.
    [[nodiscard]] bool endless() const {
        return !result_.pieces.empty() && result_.pieces.back().kind != TextTemplate::Kind::literal;
    }

    std::string_view text_;
    bool placeholders_;
    std::size_t at_ = 0;
    TextTemplate result_;
};

}  // namespace

bool TextTemplate::has(std::string_view name) const {
    return std::ranges::any_of(pieces, [&](const Piece& piece) {
        return piece.kind != Kind::literal && piece.kind != Kind::skip && piece.text == name;
    });
}

std::vector<std::string_view> TextTemplate::names() const {
    std::vector<std::string_view> names;
    for (const auto& piece : pieces)
        if (piece.kind != Kind::literal && piece.kind != Kind::skip) names.emplace_back(piece.text);
    return names;
}

std::expected<TextTemplate, TemplateError> parse_template(std::string_view text) {
    return Parser(text, true).run();
}

std::expected<std::string, TemplateError> parse_bytes(std::string_view text) {
    auto parsed = Parser(text, false).run();
    if (!parsed) return std::unexpected(parsed.error());
    return parsed->pieces.empty() ? std::string() : std::move(parsed->pieces.front().text);
}

}  // namespace takt::model
