// One line at a time. A stack holds the open block collections with the columns of their keys or dashes. A
// line closes all collections that are indented deeper, then belongs to the innermost one that is left.
//
// Where yaml-cpp could read a line in another way than it looks, the reader gives up: a line that is indented
// more than its collection (it continues the text before), a key or dash without a value, tabs, document
// markers.
#include "plain_yaml.hpp"

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace takt::file {
namespace {

using Kind = model::Node::Kind;

constexpr std::size_t kLongestKey = 512;  // yaml-cpp: 1024 characters up to the colon

// What a character may be, as bits.
enum : std::uint8_t {
    kKeyBegins = 1,
    kInKey = 2,
    kTextBegins = 4,
    kEndsInFlow = 8,  // of a plain text in a flow collection, or needs a closer look there
    kEndsInBlock = 16,
};

constexpr std::array<std::uint8_t, 256> character_table() {
    std::array<std::uint8_t, 256> table{};
    const auto add = [&table](std::string_view characters, unsigned bits) {
        for (const char c : characters) {
            auto& entry = table[static_cast<std::uint8_t>(c)];
            entry = static_cast<std::uint8_t>(entry | bits);
        }
    };
    const auto add_range = [&table](unsigned first, unsigned last, unsigned bits) {
        for (unsigned c = first; c <= last; ++c) table[c] = static_cast<std::uint8_t>(table[c] | bits);
    };
    for (const auto& [first, last] : {std::pair{'a', 'z'}, {'A', 'Z'}, {'0', '9'}})
        add_range(static_cast<unsigned>(first), static_cast<unsigned>(last),
                  kKeyBegins | kInKey | kTextBegins);
    add_range(0x80, 0xFF, kKeyBegins | kInKey | kTextBegins);
    add("_", kKeyBegins | kInKey | kTextBegins);
    add("-./", kInKey);
    add("./+~(<$=", kTextBegins);
    add(",[]{}?", kEndsInFlow);
    add(":#\t", kEndsInFlow | kEndsInBlock);
    return table;
}

constexpr auto kCharacters = character_table();

bool is(char c, unsigned bits) {
    return (kCharacters[static_cast<std::uint8_t>(c)] & bits) != 0;
}

// The words that yaml-cpp reads as null.
bool is_null(std::string_view text) {
    return text == "~" || text == "null" || text == "Null" || text == "NULL";
}

class PlainReader {
public:
    PlainReader(const Source& source, YamlBuilder& builder) : text_(source.text()), builder_(builder) {}

    /// Whether all of the text was read.
    bool read();

private:
    struct Block {
        Kind kind;
        std::size_t column;
    };

    // Lines. The reader stands at `at_`; the line without its line break ends at `end_`.
    bool next_line();
    bool next_line_with_content();
    [[nodiscard]] std::size_t column() const { return at_ - begin_; }
    [[nodiscard]] bool at_end() const { return at_ == end_; }
    [[nodiscard]] bool at(char c) const { return at_ < end_ && text_[at_] == c; }
    [[nodiscard]] bool at_comment() const { return at('#') && (at_ == begin_ || text_[at_ - 1] == ' '); }
    [[nodiscard]] bool followed_by_space(std::size_t offset) const {
        return offset + 1 >= end_ || text_[offset + 1] == ' ';
    }
    [[nodiscard]] bool at_dash() const { return at('-') && followed_by_space(at_); }
    [[nodiscard]] bool at_document_marker() const;
    void skip_spaces() {
        while (at(' ')) ++at_;
    }
    bool rest_is_empty();

    // Block collections.
    bool line();
    bool nested();
    bool first_entry();
    bool entry();
    bool entry_or_pair();
    bool pair(std::size_t key_end);
    bool block_value();
    void open(Kind kind);
    void close();

    // Scalars and flow collections.
    [[nodiscard]] std::size_t key_end() const;
    bool quoted();
    bool plain(unsigned ends);
    bool ends_plain(std::size_t offset, unsigned ends, bool& wrong) const;
    void add(std::size_t offset, std::size_t end);
    bool flow();
    bool flow_item(Kind kind);
    bool flow_value();
    bool skip_to_content();

    std::string_view text_;
    YamlBuilder& builder_;
    std::size_t next_ = 0;  // the begin of the next line
    std::size_t begin_ = 0;
    std::size_t end_ = 0;
    std::size_t at_ = 0;
    std::vector<Block> blocks_;
    bool pending_ = false;  // the value of the last key or dash is in the following lines
    bool begun_ = false;
    bool wrong_ = false;  // something that only yaml-cpp reads
};

bool PlainReader::next_line() {
    if (next_ >= text_.size()) return false;
    begin_ = at_ = next_;
    end_ = std::min(text_.find('\n', begin_), text_.size());
    next_ = end_ + 1;
    if (end_ > begin_ && text_[end_ - 1] == '\r') --end_;
    return true;
}

bool PlainReader::at_document_marker() const {
    const auto rest = text_.substr(begin_, 3);
    return rest == "---" || rest == "..." || rest.starts_with('%');
}

// The reader then stands at the first character of the content.
bool PlainReader::next_line_with_content() {
    while (next_line()) {
        if (at_document_marker()) {
            wrong_ = true;
            return false;
        }
        skip_spaces();
        if (!at_end() && !at('#')) return true;
    }
    return false;
}

// Only spaces or a comment follow.
bool PlainReader::rest_is_empty() {
    skip_spaces();
    return at_end() || at_comment();
}

bool PlainReader::read() {
    while (next_line_with_content())
        if (!line()) return false;
    if (wrong_ || pending_ || !begun_) return false;
    while (!blocks_.empty()) close();
    return true;
}

bool PlainReader::line() {
    if (pending_ || !begun_) return nested();
    while (!blocks_.empty() &&
           (blocks_.back().column > column() ||
            (blocks_.back().column == column() && blocks_.back().kind == Kind::list && !at_dash())))
        close();
    if (blocks_.empty() || blocks_.back().column != column()) return false;
    if (blocks_.back().kind == Kind::list) return entry();
    const std::size_t end = key_end();
    return end > 0 && pair(end);
}

// A collection that begins in a line of its own: the whole document, or the value of the line before.
bool PlainReader::nested() {
    if (begun_) {
        const Block& outer = blocks_.back();
        const bool deeper = column() > outer.column;
        const bool list_below_key = column() == outer.column && outer.kind == Kind::mapping && at_dash();
        if (!deeper && !list_below_key) return false;
    }
    pending_ = false;
    begun_ = true;
    if (at_dash()) return first_entry();
    const std::size_t end = key_end();
    if (end == 0) return false;
    open(Kind::mapping);
    return pair(end);
}

void PlainReader::open(Kind kind) {
    builder_.begin(kind, at_);
    blocks_.push_back({kind, column()});
}

void PlainReader::close() {
    builder_.end();
    blocks_.pop_back();
}

bool PlainReader::first_entry() {
    open(Kind::list);
    return entry();
}

bool PlainReader::entry() {
    ++at_;
    if (rest_is_empty()) {
        pending_ = true;
        return true;
    }
    return entry_or_pair();
}

bool PlainReader::entry_or_pair() {
    if (at_dash()) return first_entry();
    const std::size_t end = key_end();
    if (end == 0) return block_value();
    open(Kind::mapping);
    return pair(end);
}

bool PlainReader::pair(std::size_t key_end) {
    add(at_, key_end);
    at_ = key_end + 1;
    if (rest_is_empty()) {
        pending_ = true;
        return true;
    }
    return block_value();
}

bool PlainReader::block_value() {
    const bool read = at('{') || at('[') ? flow() : at('"') || at('\'') ? quoted() : plain(kEndsInBlock);
    return read && rest_is_empty();
}

// The offset of the colon behind the key here; 0 if there is no key.
std::size_t PlainReader::key_end() const {
    if (at_end() || !is(text_[at_], kKeyBegins)) return 0;
    std::size_t end = at_ + 1;
    while (end < end_ && is(text_[end], kInKey)) ++end;
    const bool key = end < end_ && text_[end] == ':' && followed_by_space(end) && end - at_ <= kLongestKey;
    return key ? end : 0;
}

void PlainReader::add(std::size_t offset, std::size_t end) {
    const auto text = text_.substr(offset, end - offset);
    if (is_null(text))
        builder_.add_null(offset);
    else
        builder_.add_text(offset, text, false);
}

bool PlainReader::quoted() {
    const char quote = text_[at_];
    const auto inside = text_.substr(at_ + 1, end_ - at_ - 1);
    const std::size_t length = inside.find(quote);
    if (length == std::string_view::npos) return false;
    const auto text = inside.substr(0, length);
    const bool escapes = quote == '"' ? text.contains('\\') : inside.substr(length + 1).starts_with(quote);
    if (escapes) return false;
    builder_.add_text(at_, text, true);
    at_ += length + 2;
    return true;
}

// A plain text up to a comment, the end of the line, or, in a flow collection, one of its marks.
bool PlainReader::plain(unsigned ends) {
    const char first = at_end() ? '\0' : text_[at_];
    const bool number = first == '-' && at_ + 1 < end_ && is(text_[at_ + 1], kKeyBegins);
    if (!number && !is(first, kTextBegins)) return false;
    bool wrong = false;
    std::size_t end = at_ + 1;
    while (end < end_ && !(is(text_[end], ends) && ends_plain(end, ends, wrong))) ++end;
    if (wrong || (ends == kEndsInFlow && end == end_)) return false;
    const std::size_t behind = end;
    while (text_[end - 1] == ' ') --end;
    add(at_, end);
    at_ = behind;
    return true;
}

/// @param wrong  set at a mark that would make the text something else
bool PlainReader::ends_plain(std::size_t offset, unsigned ends, bool& wrong) const {
    const bool in_flow = ends == kEndsInFlow;
    switch (text_[offset]) {
        case ':':
            wrong = followed_by_space(offset) || (in_flow && is(text_[offset + 1], kEndsInFlow));
            return wrong;
        case '#':
            if (text_[offset - 1] != ' ') return false;
            wrong = in_flow;
            return true;
        case ',':
        case ']':
        case '}': return true;
        default: wrong = true; return true;
    }
}

// From an opening bracket to behind its closing one.
bool PlainReader::flow() {
    const Kind kind = text_[at_] == '{' ? Kind::mapping : Kind::list;
    const char close = kind == Kind::mapping ? '}' : ']';
    builder_.begin(kind, at_);
    ++at_;
    if (!skip_to_content()) return false;
    if (!at(close)) {
        while (true) {
            if (!flow_item(kind)) return false;
            skip_spaces();
            if (at(close)) break;
            if (!at(',')) return false;
            ++at_;
            if (!skip_to_content()) return false;
        }
    }
    ++at_;
    builder_.end();
    return true;
}

bool PlainReader::flow_item(Kind kind) {
    if (kind == Kind::list) return flow_value();
    const std::size_t end = key_end();
    if (end == 0) return false;
    add(at_, end);
    at_ = end + 1;
    skip_spaces();
    return flow_value();
}

bool PlainReader::flow_value() {
    if (at('{') || at('[')) return flow();
    if (at('"') || at('\'')) return quoted();
    return plain(kEndsInFlow);
}

// Past spaces, comments and line breaks inside a flow collection.
bool PlainReader::skip_to_content() {
    return !rest_is_empty() || next_line_with_content();
}

}  // namespace

bool read_plain_yaml(const Source& source, YamlBuilder& builder) {
    try {
        return PlainReader(source, builder).read();
    } catch (const Stop&) {
        return false;
    }
}

}  // namespace takt::file
