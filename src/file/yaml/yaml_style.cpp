#include "yaml/yaml_style.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "takt/file/edit.hpp"
#include "takt/file/schema.hpp"
#include "yaml/yaml_scalar.hpp"

namespace takt::file {
namespace {

using model::Node;
using model::Object;

constexpr std::array kBlockObjects{Object::line, Object::device,     Object::server,
                                   Object::unit, Object::instrument, Object::output};

/// Looks at all collections of a text, outer ones first.
class StyleReader {
public:
    explicit StyleReader(std::string_view text) : text_(text) {
        if (text.contains("\r\n")) style_.line_break = "\r\n";
    }

    void read(const Layout& layout, std::optional<Object> object) {
        if (layout.node->kind == Node::Kind::mapping) {
            note_padding(layout);
            for (std::size_t i = 0; i < layout.parts.size(); ++i) {
                const auto& value = layout.parts[i].value;
                note_indent(layout, value);
                read(value, object_behind(object, layout.node->entries[i].key.text));
            }
        } else {
            for (const auto& part : layout.parts) {
                if (object && part.value.node->kind == Node::Kind::mapping)
                    style_.block_items.try_emplace(*object, part.value.style == Layout::Style::block);
                read(part.value, object);
            }
        }
    }

    YamlStyle take() { return std::move(style_); }

private:
    void note_padding(const Layout& layout) {
        if (layout.style != Layout::Style::flow || std::exchange(padding_known_, true)) return;
        style_.padded = text_.substr(layout.begin).starts_with("{ ");
    }

    void note_indent(const Layout& outer, const Layout& inner) {
        if (outer.style != Layout::Style::block || inner.style != Layout::Style::block) return;
        if (inner.column < outer.column) return;
        if (inner.node->kind == Node::Kind::list) {
            if (!std::exchange(list_known_, true)) style_.list_indent = inner.column - outer.column;
        } else if (!std::exchange(mapping_known_, true)) {
            style_.mapping_indent = inner.column - outer.column;
        }
    }

    std::string_view text_;
    YamlStyle style_;
    bool padding_known_ = false;
    bool list_known_ = false;
    bool mapping_known_ = false;
};

std::string key_text(const Node& key, bool flow) {
    return scalar_text(key.text, ScalarUse::any, flow);
}

}  // namespace

YamlStyle style_of(std::string_view text, const Layout& root) {
    StyleReader reader(text);
    reader.read(root, Object::project);
    return reader.take();
}

std::size_t rank_of(std::optional<Object> object, std::string_view key) {
    if (!object) return kNoRank;
    const auto fields = model::fields(*object);
    const auto found = std::ranges::find(fields, key, &model::Field::key);
    return found == fields.end() ? kNoRank : static_cast<std::size_t>(found - fields.begin());
}

std::vector<const Node::Entry*> ordered_entries(const Node& mapping, std::optional<Object> object) {
    std::vector<std::pair<std::size_t, const Node::Entry*>> ranked;
    for (const auto& entry : mapping.entries)
        if (entry.key.text != kOriginKey) ranked.emplace_back(rank_of(object, entry.key.text), &entry);
    std::ranges::stable_sort(ranked, {}, &std::pair<std::size_t, const Node::Entry*>::first);
    std::vector<const Node::Entry*> entries;
    for (const auto& [rank, entry] : ranked) entries.push_back(entry);
    return entries;
}

std::string YamlWriter::flow_item(const Node& item, std::optional<Object> object) const {
    switch (item.kind) {
        case Node::Kind::null: return "null";
        case Node::Kind::scalar: return scalar_text(item.text, ScalarUse::any, true);
        case Node::Kind::list: return flow_list(item, object);
        case Node::Kind::mapping: return flow_mapping(item, object);
    }
    return {};
}

std::string YamlWriter::flow_list(const Node& node, std::optional<Object> object) const {
    std::string text;
    for (const auto& item : node.items) text.append(text.empty() ? "" : ", ").append(flow_item(item, object));
    return "[" + text + "]";
}

std::string YamlWriter::flow_mapping(const Node& node, std::optional<Object> object) const {
    std::string text;
    for (const auto* entry : ordered_entries(node, object))
        text.append(text.empty() ? "" : ", ").append(flow_entry(node, *entry, object));
    if (text.empty()) return "{}";
    return style_.padded ? "{ " + text + " }" : "{" + text + "}";
}

std::string YamlWriter::flow_entry(const Node& owner, const Node::Entry& entry,
                                   std::optional<Object> object) const {
    return key_text(entry.key, true) + ": " + value_text(owner, entry, object, true);
}

std::string YamlWriter::value_text(const Node& owner, const Node::Entry& entry, std::optional<Object> object,
                                   bool flow) const {
    if (entry.value.kind == Node::Kind::scalar)
        return scalar_text(entry.value.text, use_of(object, owner, entry.key.text), flow);
    return flow_item(entry.value, object_behind(object, entry.key.text));
}

bool YamlWriter::needs_lines(const Node& value) const {
    if (value.kind == Node::Kind::list)
        return std::ranges::any_of(value.items, [this](const Node& item) {
            return item.kind == Node::Kind::mapping || needs_lines(item);
        });
    return std::ranges::any_of(value.entries, [this](const auto& entry) { return needs_lines(entry.value); });
}

bool YamlWriter::is_block_item(const Node& item, std::optional<Object> object) const {
    if (item.kind != Node::Kind::mapping || ordered_entries(item, object).empty()) return false;
    if (needs_lines(item)) return true;
    if (!object) return false;
    const auto known = style_.block_items.find(*object);
    if (known != style_.block_items.end()) return known->second;
    return std::ranges::find(kBlockObjects, *object) != kBlockObjects.end();
}

std::string YamlWriter::block_entry(const Node& owner, const Node::Entry& entry, std::optional<Object> object,
                                    std::size_t column) const {
    const auto key = key_text(entry.key, false) + ":";
    if (needs_lines(entry.value))
        return key + style_.line_break + lines(entry.value, object_behind(object, entry.key.text), column);
    if (entry.value.kind == Node::Kind::null) return key + style_.line_break;
    return key + " " + value_text(owner, entry, object, false) + style_.line_break;
}

std::string YamlWriter::lines(const Node& value, std::optional<Object> object, std::size_t column) const {
    std::string text;
    if (value.kind == Node::Kind::list) {
        const auto dashes = column + style_.list_indent;
        for (const auto& item : value.items)
            text.append(dashes, ' ').append(block_item(item, object, dashes, is_block_item(item, object)));
        return text;
    }
    const auto keys = column + std::max<std::size_t>(style_.mapping_indent, 1);
    for (const auto* entry : ordered_entries(value, object))
        text.append(keys, ' ').append(block_entry(value, *entry, object, keys));
    return text;
}

std::string YamlWriter::block_item(const Node& item, std::optional<Object> object, std::size_t column,
                                   bool block, std::size_t gap) const {
    if (item.kind == Node::Kind::null) return "-" + style_.line_break;
    const auto entries = ordered_entries(item, object);
    const auto dash = "-" + std::string(gap - 1, ' ');
    if (!block || entries.empty()) {
        const auto text = item.kind == Node::Kind::scalar ? scalar_text(item.text, ScalarUse::any, false)
                                                          : flow_item(item, object);
        return dash + text + style_.line_break;
    }
    std::string text;
    for (const auto* entry : entries)
        text.append(text.empty() ? dash : std::string(column + gap, ' '))
            .append(block_entry(item, *entry, object, column + gap));
    return text;
}

}  // namespace takt::file
