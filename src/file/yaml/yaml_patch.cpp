#include "yaml/yaml_patch.hpp"

#include <algorithm>
#include <utility>

#include "takt/file/schema.hpp"

namespace takt::file {

using model::Node;
using Style = Layout::Style;

YamlPatch::YamlPatch(std::string_view text, const Layout& layout)
    : text_(text), root_(layout), style_(style_of(text, layout)) {}

std::string YamlPatch::apply(const Node& wanted) {
    out_.reserve(text_.size() + text_.size() / 8);
    copy(0, root_.begin);
    const Place place{.object = model::Object::project};
    if (root_.style == Style::block && ordered_entries(wanted, place.object).empty())
        out_ += "{}" + style_.line_break;
    else
        put_value(root_, wanted, place);
    copy(root_.end, text_.size());
    return std::move(out_);
}

YamlPatch::Place YamlPatch::place_of(const Node& owner, std::string_view key, Object object,
                                     bool flow) const {
    return {.object = object_behind(object, key), .use = use_of(object, owner, key), .flow = flow};
}

bool YamlPatch::stays_in_place(const Layout& old, const Node& wanted) const {
    if (old.node->kind != wanted.kind || old.style == Style::absent) return false;
    if (old.style == Style::flow) return !old.parts.empty() || !writer_.needs_lines(wanted);
    if (old.style != Style::block) return true;
    return wanted.kind == Node::Kind::list ? !wanted.items.empty()
                                           : !ordered_entries(wanted, std::nullopt).empty();
}

void YamlPatch::put_value(const Layout& old, const Node& wanted, const Place& place) {
    if (same_document(*old.node, wanted)) return copy(old.begin, old.end);
    if (old.node->kind != wanted.kind || old.style == Style::pair) {
        out_ += wanted.kind == Node::Kind::scalar ? scalar_text(wanted.text, place.use, place.flow)
                                                  : writer_.flow_item(wanted, place.object);
    } else if (wanted.kind == Node::Kind::scalar) {
        out_ += scalar_text_like(wanted.text, place.use, place.flow, old, text_, style_.line_break);
    } else if (wanted.kind == Node::Kind::list) {
        old.style == Style::block ? put_block_list(old, wanted, place.object)
                                  : put_flow_list(old, wanted, place);
    } else {
        old.style == Style::block ? put_block_mapping(old, wanted, place.object)
                                  : put_flow_mapping(old, wanted, place.object);
    }
}

Origins YamlPatch::origins_of(const Layout& old, const Node& wanted) const {
    auto origins = match_items(*old.node, wanted);
    if (!origins) throw EditError{EditError::Kind::origin, path_};
    return *std::move(origins);
}

YamlPatch::Path::Path(YamlPatch& patch, std::string_view key)
    : path_(patch.path_), size_(patch.path_.size()) {
    if (!path_.empty()) path_ += '.';
    path_ += key;
}

YamlPatch::Path::Path(YamlPatch& patch, std::size_t index) : path_(patch.path_), size_(patch.path_.size()) {
    path_ += '[' + std::to_string(index) + ']';
}

std::vector<EntryStep> entry_steps(const Node& old, const Node& wanted, std::optional<model::Object> object) {
    // New keys by the old entry that they follow; the first list is for the beginning.
    std::vector<std::vector<const Node::Entry*>> added(old.entries.size() + 1);
    std::vector<const Node*> kept;
    for (std::size_t i = 0; i < old.entries.size(); ++i)
        kept.push_back(find_near(wanted, old.entries[i].key.text, i));
    for (const auto* entry : ordered_entries(wanted, object)) {
        const auto known = static_cast<std::size_t>(entry - wanted.entries.data());
        if (find_near(old, entry->key.text, known) != nullptr) continue;
        const auto rank = rank_of(object, entry->key.text);
        std::size_t place = 0;
        for (std::size_t i = 0; i < kept.size(); ++i)
            if (kept[i] != nullptr && (rank == kNoRank || rank_of(object, old.entries[i].key.text) < rank))
                place = i + 1;
        added[place].push_back(entry);
    }
    std::vector<EntryStep> steps;
    for (std::size_t i = 0; i <= old.entries.size(); ++i) {
        for (const auto* entry : added[i]) steps.push_back({.entry = entry});
        if (i < kept.size()) steps.push_back({.old = i, .kept = kept[i]});
    }
    return steps;
}

}  // namespace takt::file
