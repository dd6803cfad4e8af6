// Matching a template against a text, left to right without backtracking. A number takes the longest valid
// prefix. A text placeholder ends before the first occurrence of the following literal, or at the end of the
// text.
#include "takt/endpoint/answer.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>
#include <string>

#include "takt/base/ascii.hpp"
#include "takt/value/codec.hpp"
#include "takt/wire/frame.hpp"

namespace takt::endpoint {
namespace {

using Kind = model::TextTemplate::Kind;

constexpr std::size_t kMostDigits = 64;

std::string_view as_text(Bytes bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Consumes tokens at the front of a text.
class Matcher {
public:
    explicit Matcher(std::string_view text) : rest_(text) {}

    [[nodiscard]] bool at_end() const { return rest_.empty(); }

    bool literal(std::string_view text) {
        if (!rest_.starts_with(text)) return false;
        rest_.remove_prefix(text.size());
        return true;
    }

    /// The text before `text`; all of it if `text` is empty.
    std::optional<std::string_view> before(std::string_view text) {
        const auto end = text.empty() ? rest_.size() : rest_.find(text);
        if (end == std::string_view::npos) return std::nullopt;
        const auto found = rest_.substr(0, end);
        rest_.remove_prefix(end);
        return found;
    }

    std::optional<value::Value> number() {
        blanks();
        std::string digits;
        if (!rest_.empty() && (rest_[0] == '+' || rest_[0] == '-')) {
            if (rest_[0] == '-') digits += '-';
            rest_.remove_prefix(1);
            blanks();  // some scales print "-  1.5"
        }
        const std::size_t whole = take_digits(digits);
        std::size_t fraction = 0;
        bool integer = true;
        if (rest_.starts_with('.')) {
            rest_.remove_prefix(1);
            digits += '.';
            integer = false;
            fraction = take_digits(digits);
        }
        if (whole + fraction == 0 || digits.size() > kMostDigits) return std::nullopt;
        if (take_exponent(digits)) integer = false;
        return integer ? parse_integer(digits) : parse_real(digits);
    }

    std::optional<value::Value> hex() {
        blanks();
        std::uint64_t number = 0;
        const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), number, 16);
        if (error != std::errc()) return std::nullopt;
        rest_.remove_prefix(static_cast<std::size_t>(end - rest_.data()));
        return number;
    }

private:
    void blanks() { rest_.remove_prefix(std::min(rest_.find_first_not_of(' '), rest_.size())); }

    std::size_t take_digits(std::string& digits) {
        std::size_t count = 0;
        while (count < rest_.size() && is_digit(rest_[count])) ++count;
        digits.append(rest_.substr(0, std::min(count, kMostDigits + 1)));
        rest_.remove_prefix(count);
        return count;
    }

    /// An `e` belongs to the number only if digits follow.
    bool take_exponent(std::string& digits) {
        if (rest_.empty() || (rest_[0] != 'e' && rest_[0] != 'E')) return false;
        std::size_t at = 1;
        if (at < rest_.size() && (rest_[at] == '+' || rest_[at] == '-')) ++at;
        if (at == rest_.size() || !is_digit(rest_[at])) return false;
        digits += 'e';
        if (rest_[1] == '-') digits += '-';
        rest_.remove_prefix(at);
        take_digits(digits);
        return true;
    }

    static std::optional<value::Value> parse_integer(const std::string& digits) {
        std::int64_t number = 0;
        const auto* const last = digits.data() + digits.size();
        const auto [end, error] = std::from_chars(digits.data(), last, number);
        if (error == std::errc() && end == last) return number;
        return parse_real(digits);
    }

    static std::optional<value::Value> parse_real(const std::string& digits) {
        double number = 0;
        const auto* const last = digits.data() + digits.size();
        const auto [end, error] = std::from_chars(digits.data(), last, number);
        if (error != std::errc() || end != last || !std::isfinite(number)) return std::nullopt;
        return number;
    }

    std::string_view rest_;
};

bool checks(const model::AnswerFormat& format, Bytes answer) {
    switch (format.checksum) {
        case model::Checksum::none: return true;
        case model::Checksum::sum:
            return std::accumulate(answer.begin(), answer.end() - 1, 0U) % 256 == answer.back();
        case model::Checksum::exclusive_or:
            return std::accumulate(answer.begin(), answer.end() - 1, 0U, std::bit_xor<>()) == answer.back();
        case model::Checksum::crc16: {
            const auto body = answer.first(answer.size() - 2);
            return wire::crc16(body) == (answer[body.size()] | answer[body.size() + 1] << 8);
        }
    }
    return false;
}

std::optional<value::Value> read_field(const model::BinaryField& field, Bytes answer) {
    const auto bytes = answer.subspan(field.offset, field.bytes);
    if (!field.type) {
        if (field.is_signed) return std::int64_t{static_cast<std::int8_t>(bytes[0])};
        return std::uint64_t{bytes[0]};
    }
    std::array<std::uint16_t, 4> registers{};
    const std::size_t count = field.bytes / 2U;
    for (std::size_t i = 0; i < count; ++i)
        registers[i] = static_cast<std::uint16_t>(bytes[2 * i] << 8 | bytes[2 * i + 1]);
    value::Layout layout;
    layout.type = *field.type;
    layout.order = field.order;
    const auto value = value::decode(layout, std::span(registers).first(count));
    if (!value) return std::nullopt;
    if (const auto* const real = std::get_if<double>(&*value); real != nullptr && !std::isfinite(*real))
        return std::nullopt;
    return *value;
}

Measurements* read_fields(const model::AnswerFormat& format, Bytes answer, Measurements& found) {
    for (const auto& field : format.fields) {
        auto value = read_field(field, answer);
        if (!value) return nullptr;
        found.push_back({field.name, *std::move(value)});
    }
    return &found;
}

}  // namespace

std::optional<Measurements> match(const model::TextTemplate& pattern, std::string_view text) {
    Matcher matcher(text);
    Measurements found;
    for (std::size_t i = 0; i < pattern.pieces.size(); ++i) {
        const auto& piece = pattern.pieces[i];
        std::optional<value::Value> value;
        switch (piece.kind) {
            case Kind::literal:
                if (!matcher.literal(piece.text)) return std::nullopt;
                continue;
            case Kind::number: value = matcher.number(); break;
            case Kind::hex: value = matcher.hex(); break;
            case Kind::text:
            case Kind::skip: {
                // A placeholder is followed by a literal or by the end of the template.
                const bool last = i + 1 == pattern.pieces.size();
                const auto part = matcher.before(last ? std::string_view() : pattern.pieces[i + 1].text);
                if (!part) return std::nullopt;
                if (piece.kind == Kind::skip) continue;
                value = std::string(trimmed(*part));
                break;
            }
        }
        if (!value) return std::nullopt;
        found.push_back({piece.text, *std::move(value)});
    }
    if (!matcher.at_end()) return std::nullopt;
    return found;
}

std::optional<Measurements> read_answer(const model::AnswerFormat& format, Bytes answer) {
    if (!format.until.empty()) {
        const auto text = as_text(answer);
        if (!text.ends_with(format.until)) return std::nullopt;
        return match(format.pattern, text.substr(0, text.size() - format.until.size()));
    }
    if (answer.size() != format.length || !as_text(answer).starts_with(format.begins) ||
        !checks(format, answer))
        return std::nullopt;
    Measurements found;
    if (read_fields(format, answer, found) == nullptr) return std::nullopt;
    return found;
}

Found find_answer(const model::AnswerFormat& format, Bytes bytes) {
    const auto text = as_text(bytes);
    if (!format.until.empty()) {
        const auto end = text.find(format.until);
        return {0, end == std::string_view::npos ? 0 : end + format.until.size()};
    }
    std::size_t skip = 0;
    const std::string_view begins = format.begins;
    while (skip < text.size() &&
           !text.substr(skip).starts_with(begins.substr(0, std::min(begins.size(), text.size() - skip))))
        ++skip;
    return {skip, bytes.size() - skip >= format.length ? format.length : std::size_t{0}};
}

}  // namespace takt::endpoint
