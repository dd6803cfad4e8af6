// Builds the located document from the events of yaml-cpp. Scalars stay raw text with their source location;
// module model parses the numbers. Aliases, anchors, tags and further documents are findings.
//
// yaml-cpp is repaired in three points: it accepts an open quote at the end of the file, gives a missing
// value the location of the next token, and takes text indented less than the first line for a new document.
#include "yaml/yaml_builder.hpp"

#include <yaml-cpp/mark.h>

#include <algorithm>
#include <iterator>
#include <ranges>

#include "takt/file/load.hpp"

namespace takt::file {
namespace {

using model::Node;

// The offset of the closing quote, or npos. yaml-cpp lets the end of the file close the quote.
std::size_t closing_quote(std::string_view text, std::size_t open) {
    const char quote = text[open];
    for (auto at = open + 1; at < text.size(); ++at) {
        if (quote == '"' && text[at] == '\\') {
            ++at;
        } else if (text[at] == quote) {
            if (quote == '"' || at + 1 >= text.size() || text[at + 1] != quote) return at;
            ++at;
        }
    }
    return std::string_view::npos;
}

bool starts_explicit_null(std::string_view text) {
    constexpr std::string_view kBeginnings[] = {"~", "null", "Null", "NULL", "&", "!"};
    return std::ranges::any_of(kBeginnings, [&](auto beginning) { return text.starts_with(beginning); });
}

}  // namespace

std::size_t offset_of(const YAML::Mark& mark, const Source& source) {
    return std::min(static_cast<std::size_t>(std::max(mark.pos, 0)), source.text().size());
}

std::optional<std::uint32_t> KeyLines::add(const std::string& key, std::uint32_t line) {
    for (const auto& [known, first] : few_)
        if (known == key) return first;
    if (few_.size() < kFew) {
        few_.emplace_back(key, line);
        return std::nullopt;
    }
    const auto [first, added] = more_.emplace(key, line);
    return added ? std::nullopt : std::optional(first->second);
}

void KeyLines::clear() {
    few_.clear();
    more_.clear();
}

YamlBuilder::YamlBuilder(const Source& source, std::size_t& nodes_left, Reporter& reporter)
    : source_(source), nodes_left_(nodes_left), reporter_(reporter) {}

model::SourceLocation YamlBuilder::open_bracket() const {
    for (const auto& frame : open_frames() | std::views::reverse)
        if (frame.bracket) return frame.location;
    return {};
}

model::SourceLocation YamlBuilder::quote_before(std::size_t offset) const {
    if (quote_close_ == 0 || offset < quote_close_) return {};
    const auto between = source_.text().substr(quote_close_, offset - quote_close_);
    return between.contains('\n') ? model::SourceLocation{} : source_.location(quote_open_);
}

std::string YamlBuilder::path() const {
    std::string path;
    for (const auto& frame : open_frames()) {
        if (frame.kind == Node::Kind::list) {
            path += '[' + std::to_string(frame.items.size()) + ']';
        } else if (frame.expect != Expect::key && frame.key.kind == Node::Kind::scalar) {
            if (!path.empty()) path += '.';
            path += frame.key.text;
        }
    }
    return path;
}

void YamlBuilder::OnDocumentStart(const YAML::Mark& mark) {
    if (++documents_ == 1) return;
    // Without "---" the new document is really text indented less than the first line.
    const auto offset = offset_of(mark, source_);
    reporter_.error(source_.stands_at(offset, "---") ? "file.second_document" : "file.left_over",
                    source_.location(offset));
    throw Stop{};
}

void YamlBuilder::OnNull(const YAML::Mark& mark, YAML::anchor_t) {
    const auto offset = offset_of(mark, source_);
    count(offset);
    Node node;
    node.location = location_of_missing(offset);
    attach(std::move(node));
}

void YamlBuilder::OnAlias(const YAML::Mark& mark, YAML::anchor_t) {
    const auto location = source_.location(offset_of(mark, source_));
    reporter_.error("file.alias", location, {.path = path()});
    leave_out(location);
}

void YamlBuilder::OnAnchor(const YAML::Mark& mark, const std::string& name) {
    reporter_.error("file.anchor", source_.location(offset_of(mark, source_)),
                    {.value = name, .path = path()});
}

void YamlBuilder::OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t,
                           const std::string& value) {
    const auto offset = offset_of(mark, source_);
    count(offset);
    check_tag(offset, tag);
    check_quotes(offset, value);
    Node node;
    node.kind = Node::Kind::scalar;
    node.location = source_.location(offset);
    node.text = value;
    node.quoted = tag == "!";
    attach(std::move(node));
}

void YamlBuilder::OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t,
                                  YAML::EmitterStyle::value) {
    begin(Node::Kind::list, offset_of(mark, source_), tag);
}

void YamlBuilder::OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t,
                             YAML::EmitterStyle::value) {
    begin(Node::Kind::mapping, offset_of(mark, source_), tag);
}

void YamlBuilder::begin(Node::Kind kind, std::size_t offset, const std::string& tag) {
    count(offset);
    check_tag(offset, tag);
    if (depth_ >= kMaxDepth) {
        reporter_.error("file.too_deep", source_.location(offset), {.allowed = std::to_string(kMaxDepth)});
        throw Stop{};
    }
    if (depth_ == frames_.size()) frames_.emplace_back();
    Frame& frame = frames_[depth_++];
    frame.kind = kind;
    frame.location = source_.location(offset);
    frame.bracket = source_.stands_at(offset, "[") || source_.stands_at(offset, "{");
    frame.expect = Expect::key;
}

// The node gets memory for exactly its members.
void YamlBuilder::end() {
    Frame& frame = frames_[--depth_];
    Node node{.kind = frame.kind, .location = frame.location};
    node.items.assign(std::move_iterator(frame.items.begin()), std::move_iterator(frame.items.end()));
    node.entries.assign(std::move_iterator(frame.entries.begin()), std::move_iterator(frame.entries.end()));
    frame.items.clear();
    frame.entries.clear();
    frame.lines.clear();
    attach(std::move(node));
}

void YamlBuilder::attach(Node&& node) {
    if (depth_ == 0) {
        root_ = std::move(node);
        return;
    }
    auto& frame = frames_[depth_ - 1];
    if (frame.kind == Node::Kind::list) {
        frame.items.push_back(std::move(node));
    } else if (frame.expect == Expect::key) {
        take_key(frame, std::move(node));
    } else {
        if (frame.expect == Expect::value) frame.entries.emplace_back(std::move(frame.key), std::move(node));
        frame.expect = Expect::key;
    }
}

void YamlBuilder::take_key(Frame& frame, Node&& node) {
    frame.key = std::move(node);
    frame.expect = Expect::nothing;
    const auto& key = frame.key;
    const auto report = [&](std::string_view code) {
        reporter_.error(code, key.location, {.value = key.text, .path = path()});
    };
    if (key.kind != Node::Kind::scalar) return report("file.key");
    if (key.text == "<<" && !key.quoted) return report("file.merge_key");
    const auto first = frame.lines.add(key.text, key.location.line);
    if (!first) {
        frame.expect = Expect::value;
        return;
    }
    reporter_.error("file.duplicate_key", key.location,
                    {.value = key.text, .path = path(), .arguments = {{"first", std::to_string(*first)}}});
}

void YamlBuilder::leave_out(const model::SourceLocation& location) {
    if (depth_ == 0 || frames_[depth_ - 1].kind == Node::Kind::list) return;
    auto& frame = frames_[depth_ - 1];
    if (frame.expect == Expect::key) {
        frame.key = {.location = location};
        frame.expect = Expect::nothing;
    } else {
        frame.expect = Expect::key;
    }
}

void YamlBuilder::count(std::size_t offset) {
    if (nodes_left_ > 0) {
        --nodes_left_;
        return;
    }
    reporter_.error("file.too_many_nodes", source_.location(offset), {.allowed = std::to_string(kMaxNodes)});
    throw Stop{};
}

// yaml-cpp reports the tag "?" for plain and "!" for quoted text. A lone "!" in the file also gives "!".
void YamlBuilder::check_tag(std::size_t offset, const std::string& tag) {
    const bool written = source_.stands_at(offset, "!");
    if (tag.empty() || tag == "?" || (tag == "!" && !written)) return;
    const auto rest = source_.text().substr(offset);
    const auto name = written ? rest.substr(0, rest.find_first_of(" \t\r\n,[]{}")) : std::string_view(tag);
    reporter_.error("file.tag", source_.location(offset), {.value = std::string(name), .path = path()});
}

void YamlBuilder::check_quotes(std::size_t offset, const std::string& value) {
    quote_open_ = quote_close_ = 0;
    if (!source_.stands_at(offset, "\"") && !source_.stands_at(offset, "'")) return;
    const auto close = closing_quote(source_.text(), offset);
    if (close == std::string_view::npos) {
        reporter_.error("file.unclosed_quote", source_.location(offset), {.path = path()});
        throw Stop{};
    }
    if (source_.text().substr(offset, close - offset).contains('\n')) {
        quote_open_ = offset;
        quote_close_ = close;
    }
    // Escape sequences can produce characters that are refused in plain text.
    if (const auto foreign = find_foreign(value))
        reporter_.error("file.control_character", source_.location(offset),
                        {.value = in_words(*foreign), .path = path()});
}

// yaml-cpp reports a missing value at the location of the next token.
model::SourceLocation YamlBuilder::location_of_missing(std::size_t offset) const {
    if (depth_ == 0 || starts_explicit_null(source_.text().substr(offset))) return source_.location(offset);
    const auto& frame = frames_[depth_ - 1];
    if (frame.kind == Node::Kind::mapping && frame.expect != Expect::key) return frame.key.location;
    if (frame.kind == Node::Kind::list)
        while (offset > 0 && std::string_view(" \t\r\n").contains(source_.text()[offset - 1])) --offset;
    return source_.location(offset > 0 ? offset - 1 : 0);
}

}  // namespace takt::file
