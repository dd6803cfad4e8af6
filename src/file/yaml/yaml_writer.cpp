// A scalar is written plain if every YAML 1.1 and 1.2 reader takes it for the same text, else in double
// quotes.
#include <fmt/format.h>

#include <algorithm>
#include <sstream>

#include "takt/file/convert.hpp"
#include "takt/model/fields.hpp"
#include "yaml/yaml_scalar.hpp"

namespace takt::file {
namespace {

using model::Kind;
using model::Node;
using model::Object;

constexpr std::size_t kIndent = 2;

bool starts_word(char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_' || c == '/' ||
           static_cast<unsigned char>(c) >= 0x80;
}

bool continues_word(char c) {
    return starts_word(c) || (c >= '0' && c <= '9') || c == '-' || c == '.' || c == '/';
}

// Words with another meaning than text in YAML 1.1 or 1.2.
bool is_reserved(std::string_view text) {
    std::string small(text);
    for (char& c : small)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + 0x20);
    return small == "null" || std::ranges::find(kBooleanWords, small) != kBooleanWords.end();
}

bool is_plain_text(std::string_view text) {
    if (text.empty() || !starts_word(text[0]) || text.ends_with(' ') || is_reserved(text)) return false;
    return std::ranges::all_of(text, [](char c) { return continues_word(c) || c == ' '; });
}

std::string quoted_scalar(std::string_view text) {
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') result += '\\';
        if (static_cast<unsigned char>(c) < 0x20)
            result += fmt::format("\\x{:02X}", c);
        else
            result += c;
    }
    return result + '"';
}

bool is_text(Object object, const Node& mapping, std::string_view key) {
    const auto* const field = model::find_field(object, key);
    if (field == nullptr) return true;
    const auto* const type = mapping.find("type");
    switch (field->kind) {
        case Kind::text:
        case Kind::words:
        case Kind::local_bool:
        case Kind::local_integer: return true;
        case Kind::constant: return type != nullptr && type->text == "string";
        default: return false;
    }
}

// The words of a cell as a list: `a, b` becomes [a, b].
std::string words_text(std::string_view text) {
    constexpr std::string_view kBetween = ",; \t";
    std::string list;
    while (true) {
        text.remove_prefix(std::min(text.find_first_not_of(kBetween), text.size()));
        if (text.empty()) return "[" + list + "]";
        const auto word = text.substr(0, text.find_first_of(kBetween));
        list.append(list.empty() ? "" : ", ")
            .append(is_plain_text(word) ? std::string(word) : quoted_scalar(word));
        text.remove_prefix(word.size());
    }
}

std::string field_text(Object object, const Node& mapping, std::string_view key, const Node& value) {
    const auto* const field = model::find_field(object, key);
    if (field != nullptr && field->kind == Kind::list && value.cell) return words_text(value.text);
    if (field != nullptr && (field->kind == Kind::reference || key == "byte_order"))
        return quoted_scalar(value.text);  // other readers would take it for a number
    if (!is_text(object, mapping, key)) return value.text;
    return is_plain_text(value.text) ? value.text : quoted_scalar(value.text);
}

class ProjectWriter {
public:
    explicit ProjectWriter(const Comments& comments) : comments_(comments) {}

    // The kind of the items of a list.
    static Object object_of(std::string_view key) {
        if (key == "lines") return Object::line;
        if (key == "devices") return Object::device;
        if (key == "locals") return Object::local;
        if (key == "servers") return Object::server;
        if (key == "units") return Object::unit;
        if (key == "banks") return Object::bank;
        if (key == "limits") return Object::limit;
        if (key == "identification") return Object::identification;
        if (key == "files") return Object::file;
        if (key == "fifos") return Object::fifo;
        if (key == "access") return Object::access;
        if (key == "relay") return Object::relay;
        if (key == "map") return Object::relay_map;
        if (key == "instruments") return Object::instrument;
        if (key == "exchanges") return Object::exchange;
        if (key == "start") return Object::start_command;
        if (key == "commands") return Object::instrument_command;
        if (key == "fields") return Object::measurement;
        if (key == "outputs") return Object::output;
        if (key == "select") return Object::output_selection;
        return Object::variable;
    }

    void mapping(Object object, const Node& node, std::size_t depth, bool after_dash) {
        bool first = after_dash;
        for (const auto& [key, value] : node.entries) {
            if (!first) text_.append(depth * kIndent, ' ');
            first = false;
            text_ += key.text + ":";
            if (value.kind == Node::Kind::list && !is_of_scalars(value))
                list(object_of(key.text), value, depth);
            else if (is_of_lists(value))
                nested(value, depth);
            else
                text_ += " " + value_text(object, node, key.text, value) + "\n";
        }
    }

    std::string take() { return std::move(text_); }

private:
    // Ranges and numbers: [0..9, 20]. An empty list is one of mappings.
    static bool is_of_scalars(const Node& list) {
        return !list.items.empty() && list.items.front().kind != Node::Kind::mapping;
    }

    static bool is_of_lists(const Node& mapping) {
        return !mapping.entries.empty() && std::ranges::all_of(mapping.entries, [](const Node::Entry& entry) {
            return entry.value.kind == Node::Kind::list && is_of_scalars(entry.value);
        });
    }

    void nested(const Node& lists, std::size_t depth) {
        text_ += '\n';
        mapping(Object::device, lists, depth + 1, false);
    }

    static std::string value_text(Object object, const Node& mapping, std::string_view key,
                                  const Node& value) {
        if (value.kind == Node::Kind::list) return list_text(object_of(key), value);
        if (value.kind != Node::Kind::mapping) return field_text(object, mapping, key, value);
        const auto* const field = model::find_field(object, key);
        return mapping_text(field != nullptr ? field->object.value_or(object) : object, value);
    }

    static std::string mapping_text(Object object, const Node& node) {
        std::string text;
        for (const auto& [key, value] : node.entries)
            text.append(text.empty() ? "" : ", ")
                .append(key.text)
                .append(": ")
                .append(value_text(object, node, key.text, value));
        return "{" + text + "}";
    }

    static std::string list_text(Object object, const Node& list) {
        std::string text;
        for (const auto& item : list.items)
            text.append(text.empty() ? "" : ", ")
                .append(item.kind == Node::Kind::list      ? list_text(object, item)
                        : item.kind == Node::Kind::mapping ? mapping_text(object, item)
                        : item.quoted                      ? quoted_scalar(item.text)
                                                           : item.text);
        return "[" + text + "]";
    }

    void list(Object object, const Node& node, std::size_t depth) {
        text_ += node.items.empty() ? " []\n" : "\n";
        for (const auto& item : node.items) {
            comment(item, depth + 1);
            text_.append((depth + 1) * kIndent, ' ');
            text_ += "- ";
            if (object == Object::line || object == Object::device || object == Object::server ||
                object == Object::unit || object == Object::instrument || object == Object::output)
                mapping(object, item, depth + 2, true);
            else
                text_ += mapping_text(object, item) + "\n";
        }
    }

    void comment(const Node& item, std::size_t depth) {
        const auto found = comments_.find(&item);
        if (found == comments_.end()) return;
        std::istringstream lines(found->second);
        for (std::string line; std::getline(lines, line);)
            text_.append(depth * kIndent, ' ').append("# ").append(line) += '\n';
    }

    const Comments& comments_;
    std::string text_;
};

}  // namespace

std::string write_project(const model::Node& root, const Comments& comments) {
    ProjectWriter writer(comments);
    writer.mapping(Object::project, root, 0, false);
    return writer.take();
}

std::string write_device_keys(const model::Node& device) {
    const Comments none;
    ProjectWriter writer(none);
    writer.mapping(Object::device, device, 0, false);
    return writer.take();
}

}  // namespace takt::file
