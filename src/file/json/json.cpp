// The parser of nlohmann-json is used as a SAX parser, because its DOM keeps the last of duplicate keys and
// does not limit nesting.
#include "takt/file/json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>

#include "takt/base/assert.hpp"
#include "takt/base/utf8.hpp"

namespace takt::file {
namespace {

using nlohmann::ordered_json;

bool is_plain(char c) {
    return c >= ' ' && c <= '~' && c != '"' && c != '\\';
}

// The library escapes C0 only. Other characters that a terminal obeys are all below U+10000.
void append_printable(std::string& out, std::string_view json) {
    while (!json.empty()) {
        const auto character = first_character(json);
        if (is_printable(character.code))
            out += json.substr(0, character.bytes);
        else
            fmt::format_to(std::back_inserter(out), "\\u{:04x}", static_cast<unsigned>(character.code));
        json.remove_prefix(character.bytes);
    }
}

// The library's algorithm (Grisu2) misses the shortest digits of one number in a thousand: it
// writes 11.661829 as 11.661828999999999.
void append_number(std::string& out, double number) {
    if (!std::isfinite(number)) {
        out += "null";
        return;
    }
    const auto begin = out.size();
    fmt::format_to(std::back_inserter(out), "{}", number);
    if (out.find_first_of(".e", begin) == std::string::npos) out += ".0";
}

/// Writes a value as text. The library writes only the texts that need care: a tree of its own values would
/// be a copy of the whole tree.
class JsonWriter {
public:
    explicit JsonWriter(int indent) : indent_(indent) {}

    void write(const Json& value) { std::visit(*this, value.value()); }
    [[nodiscard]] std::string take() { return std::move(text_); }

    void operator()(std::monostate) { text_ += "null"; }
    void operator()(bool flag) { text_ += flag ? "true" : "false"; }
    void operator()(double number) { append_number(text_, number); }
    void operator()(std::integral auto number) {
        std::array<char, 24> digits{};
        text_.append(digits.data(), std::to_chars(digits.begin(), digits.end(), number).ptr);
    }
    void operator()(const std::string& text) {
        if (!std::ranges::all_of(text, is_plain)) {
            append_printable(text_,
                             ordered_json(text).dump(-1, ' ', false, ordered_json::error_handler_t::replace));
            return;
        }
        text_ += '"';
        text_ += text;
        text_ += '"';
    }
    void operator()(const Json::Array& items) {
        write_all('[', items, ']', [this](const Json& item) { write(item); });
    }
    void operator()(const Json::Object& entries) {
        write_all('{', entries, '}', [this](const auto& entry) {
            (*this)(entry.first);
            text_ += indent_ < 0 ? ":" : ": ";
            write(entry.second);
        });
    }

private:
    template <class Members>
    void write_all(char open, const Members& members, char close, auto write_member) {
        text_ += open;
        ++depth_;
        bool first = true;
        for (const auto& member : members) {
            if (!std::exchange(first, false)) text_ += ',';
            begin_line();
            write_member(member);
        }
        --depth_;
        if (!members.empty()) begin_line();
        text_ += close;
    }
    void begin_line() {
        if (indent_ < 0) return;
        text_ += '\n';
        text_.append(static_cast<std::size_t>(indent_) * depth_, ' ');
    }

    int indent_;
    std::size_t depth_ = 0;
    std::string text_;
};

bool has_a_key_twice(const Json::Object& entries) {
    std::vector<std::string_view> keys;
    for (const auto& entry : entries) keys.push_back(entry.first);
    std::ranges::sort(keys);
    return std::ranges::adjacent_find(keys) != keys.end();
}

// A SAX handler of the JSON parser. Returning false stops the parser.
class Builder : public nlohmann::json_sax<ordered_json> {
public:
    [[nodiscard]] Json take() { return std::move(root_); }
    [[nodiscard]] const Error& error() const { return error_; }

    bool null() override { return add({}); }
    bool boolean(bool value) override { return add(value); }
    bool number_integer(std::int64_t value) override { return add(value); }
    bool number_unsigned(std::uint64_t value) override { return add(value); }
    bool number_float(double value, const std::string&) override { return add(value); }
    bool string(std::string& value) override { return add(std::move(value)); }
    bool binary(binary_t&) override { return false; }
    bool start_array(std::size_t) override { return begin(); }
    bool start_object(std::size_t) override { return begin(); }

    bool key(std::string& key) override {
        open_.back().key = std::move(key);
        return true;
    }
    bool end_array() override {
        auto items = std::move(open_.back().items);
        open_.pop_back();
        return add(Json(std::move(items)));
    }
    bool end_object() override {
        auto entries = std::move(open_.back().entries);
        if (has_a_key_twice(entries)) return refuse("a key twice");
        open_.pop_back();
        return add(Json(std::move(entries)));
    }
    bool parse_error(std::size_t position, const std::string&,
                     const nlohmann::json::exception& trouble) override {
        // "[json.exception.parse_error.101] parse error at line 1, column 2: words"
        const std::string_view what = trouble.what();
        const auto colon = what.find(": ");
        error_ = {Code::syntax,
                  colon == std::string_view::npos ? what : what.substr(colon + 2),
                  {static_cast<std::int64_t>(position)}};
        return false;
    }

private:
    struct Open {
        std::optional<std::string> key;  // of the next value, in an object
        Json::Array items;
        Json::Object entries;
    };

    bool refuse(std::string_view why) {
        error_ = {Code::syntax, why, {}};
        return false;
    }
    bool begin() {
        if (open_.size() >= Json::kMaxDepth) return refuse("too deep");
        open_.emplace_back();
        return true;
    }
    bool add(Json value) {
        if (open_.empty()) {
            root_ = std::move(value);
        } else if (auto& open = open_.back(); open.key) {
            open.entries.emplace_back(*std::exchange(open.key, std::nullopt), std::move(value));
        } else {
            open.items.push_back(std::move(value));
        }
        return true;
    }

    std::vector<Open> open_;
    Json root_;
    Error error_;
};

}  // namespace

Json::Json(float number) : value_(static_cast<double>(number)) {
    if (!std::isfinite(number)) return;
    std::array<char, 64> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
    double shortest = 0;
    std::from_chars(digits.data(), end, shortest);
    value_ = shortest;
}

void Json::set(std::string_view key, Json value) {
    TAKT_ASSERT(std::holds_alternative<Object>(value_));
    auto& entries = std::get<Object>(value_);
    const auto found = std::ranges::find(entries, key, &Object::value_type::first);
    if (found != entries.end()) {
        found->second = std::move(value);
    } else {
        entries.emplace_back(key, std::move(value));
    }
}

void Json::push_back(Json item) {
    TAKT_ASSERT(std::holds_alternative<Array>(value_));
    std::get<Array>(value_).push_back(std::move(item));
}

const Json* Json::find(std::string_view key) const {
    const auto* entries = std::get_if<Object>(&value_);
    if (!entries) return nullptr;
    const auto found = std::ranges::find(*entries, key, &Object::value_type::first);
    return found == entries->end() ? nullptr : &found->second;
}

std::string Json::dump(int indent) const {
    JsonWriter writer(indent);
    writer.write(*this);
    return writer.take();
}

Result<Json> Json::parse(std::string_view text, std::size_t max_bytes) {
    if (text.size() > max_bytes)
        return fail(Code::too_long, static_cast<std::int64_t>(text.size()),
                    static_cast<std::int64_t>(max_bytes));
    // The parser stops at a NUL and ignores the rest. JSON text contains no NUL.
    if (const auto nul = text.find('\0'); nul != std::string_view::npos)
        return fail(Code::syntax, "NUL", static_cast<std::int64_t>(nul));
    Builder builder;
    if (!ordered_json::sax_parse(text, &builder)) return std::unexpected(builder.error());
    return builder.take();
}

}  // namespace takt::file
