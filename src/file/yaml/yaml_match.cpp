#include "yaml/yaml_match.hpp"

#include <algorithm>
#include <charconv>

#include "takt/file/edit.hpp"

namespace takt::file {
namespace {

using model::Node;

std::optional<std::size_t> parsed_index(std::string_view text) {
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return index;
}

bool has_origins(const Node& list) {
    return std::ranges::any_of(list.items, [](const Node& item) { return item.kind == Node::Kind::mapping; });
}

// A list in a list has no origin: its mappings could come from another one.
bool has_no_mapping(const Node& node) {
    return node.kind != Node::Kind::mapping && std::ranges::all_of(node.items, has_no_mapping);
}

// Of lists of scalars.
Origins match_by_position(const Node& old, const Node& wanted) {
    const auto most = std::min(old.items.size(), wanted.items.size());
    std::size_t front = 0;
    while (front < most && same_document(old.items[front], wanted.items[front])) ++front;
    std::size_t back = 0;
    while (back < most - front && same_document(old.items[old.items.size() - 1 - back],
                                                wanted.items[wanted.items.size() - 1 - back]))
        ++back;
    Origins origins(wanted.items.size());
    const auto middle = most - back;
    for (std::size_t i = 0; i < middle; ++i)
        if (i < front || has_no_mapping(wanted.items[i])) origins[i] = i;
    for (std::size_t i = 1; i <= back; ++i) origins[wanted.items.size() - i] = old.items.size() - i;
    return origins;
}

// Beside mappings: scalars and lists come from equal ones, in order.
std::optional<std::size_t> next_equal(const Node& old, const Node& wanted, std::size_t& from,
                                      const std::vector<bool>& used) {
    for (; from < old.items.size(); ++from) {
        const auto& item = old.items[from];
        if (item.kind == Node::Kind::mapping || used[from]) continue;
        return same_document(item, wanted) ? std::optional(from++) : std::nullopt;
    }
    return std::nullopt;
}

}  // namespace

std::optional<Origins> match_items(const Node& old, const Node& wanted) {
    if (!has_origins(wanted)) return match_by_position(old, wanted);
    Origins origins;
    std::vector<bool> used(old.items.size());
    std::size_t from = 0;
    for (const auto& item : wanted.items) {
        const auto* const key = item.find(kOriginKey);
        std::optional<std::size_t> origin;
        if (key != nullptr) {
            origin = parsed_index(key->text);
            if (!origin || *origin >= used.size() || used[*origin]) return std::nullopt;
        } else if (item.kind != Node::Kind::mapping) {
            origin = next_equal(old, item, from, used);
        }
        if (origin) used[*origin] = true;
        origins.push_back(origin);
    }
    return origins;
}

bool keeps_order(const Origins& origins, std::size_t old_items) {
    if (origins.size() != old_items) return false;
    for (std::size_t i = 0; i < origins.size(); ++i)
        if (origins[i] != i) return false;
    return true;
}

const Node* find_near(const Node& mapping, std::string_view key, std::size_t index) {
    if (index < mapping.entries.size() && mapping.entries[index].key.text == key)
        return &mapping.entries[index].value;
    return mapping.find(key);
}

}  // namespace takt::file
