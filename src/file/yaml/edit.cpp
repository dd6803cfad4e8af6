#include "takt/file/edit.hpp"

#include <algorithm>
#include <utility>

#include "yaml/yaml_layout.hpp"
#include "yaml/yaml_match.hpp"
#include "yaml/yaml_patch.hpp"

namespace takt::file {
namespace {

using model::Node;

bool is_entry(const Node::Entry& entry) {
    return entry.key.text != kOriginKey;
}

/// Counts nodes; false beyond the limits of files.
bool fits(const Node& node, std::size_t depth, std::size_t& left) {
    if (left == 0 || depth > kMaxDepth || node.entries.size() > kMaxEditedKeys) return false;
    --left;
    return std::ranges::all_of(node.items, [&](const Node& item) { return fits(item, depth + 1, left); }) &&
           std::ranges::all_of(node.entries,
                               [&](const auto& entry) { return fits(entry.value, depth + 1, left); });
}

bool fits(const Node& node) {
    std::size_t left = kMaxNodes;
    return fits(node, 0, left);
}

/// The path of the first difference.
std::string difference(const Node& a, const Node& b, const std::string& path) {
    if (a.kind != b.kind) return path;
    if (a.kind == Node::Kind::list && a.items.size() == b.items.size())
        for (std::size_t i = 0; i < a.items.size(); ++i)
            if (!same_document(a.items[i], b.items[i]))
                return difference(a.items[i], b.items[i], path + '[' + std::to_string(i) + ']');
    for (std::size_t i = 0; i < a.entries.size(); ++i) {
        const auto& key = a.entries[i].key.text;
        const auto* const other = find_near(b, key, i);
        if (key != kOriginKey && other != nullptr && !same_document(a.entries[i].value, *other))
            return difference(a.entries[i].value, *other, path.empty() ? key : path + '.' + key);
    }
    return path;
}

std::unexpected<EditError> failed(EditError::Kind kind, std::string subject = {}) {
    return std::unexpected(EditError{kind, std::move(subject)});
}

}  // namespace

bool same_document(const Node& a, const Node& b) {
    if (a.kind != b.kind || a.text != b.text || a.items.size() != b.items.size()) return false;
    for (std::size_t i = 0; i < a.items.size(); ++i)
        if (!same_document(a.items[i], b.items[i])) return false;
    if (std::ranges::count_if(a.entries, is_entry) != std::ranges::count_if(b.entries, is_entry))
        return false;
    for (std::size_t i = 0; i < a.entries.size(); ++i) {
        if (!is_entry(a.entries[i])) continue;
        const auto* const other = find_near(b, a.entries[i].key.text, i);
        if (other == nullptr || !same_document(a.entries[i].value, *other)) return false;
    }
    return true;
}

std::expected<std::string, EditError> patched_project(const std::string& text, const Node& wanted) {
    using Kind = EditError::Kind;
    if (!fits(wanted)) return failed(Kind::too_large);
    const auto old = read_project_text({}, text);
    if (!old.readable || !old.findings.empty() || old.document.root.kind != Node::Kind::mapping)
        return failed(Kind::unreadable);
    if (!fits(old.document.root)) return failed(Kind::too_large);
    if (wanted.kind != Node::Kind::mapping) return failed(Kind::differs);
    if (same_document(old.document.root, wanted)) return text;
    const auto layout = lay_out(text, old.document.root);
    if (!layout) return failed(Kind::layout);
    std::string changed;
    try {
        changed = YamlPatch(text, *layout).apply(wanted);
    } catch (EditError& error) {
        return std::unexpected(std::move(error));
    }
    if (changed.size() > kMaxFileBytes) return failed(Kind::too_large);
    const auto again = read_project_text({}, changed);
    if (!again.findings.empty()) return failed(Kind::differs, again.findings.front().path);
    if (!same_document(again.document.root, wanted))
        return failed(Kind::differs, difference(wanted, again.document.root, {}));
    return changed;
}

}  // namespace takt::file
