#include "http/protected_keys.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <map>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "takt/file/document_json.hpp"
#include "takt/model/fields.hpp"

namespace takt::web {
namespace {

using model::Node;

/// What the field table says of a key, in any object: a key in a wrong object is protected too.
struct KeyMarks {
    bool names_host_resource = false;
    bool harmless_mapping = false;  ///< `file`: a mapping in the source of a variable, a name in a replay
};

std::map<std::string_view, KeyMarks> marked_keys() {
    std::map<std::string_view, KeyMarks> keys;
    for (const auto object : model::kObjects)
        for (const auto& field : model::fields(object)) {
            auto& marks = keys[field.key];
            if (field.names_host_resource)
                marks.names_host_resource = true;
            else if (field.kind == model::Kind::mapping)
                marks.harmless_mapping = true;
        }
    return keys;
}

bool is_protected(std::string_view key, const Node& value) {
    static const auto keys = marked_keys();
    const auto marks = keys.find(key);
    if (marks == keys.end() || !marks->second.names_host_resource) return false;
    return value.kind != Node::Kind::mapping || !marks->second.harmless_mapping;
}

std::string text_of(const Node& value) {
    auto bare = value;
    file::without_origins(bare);
    return file::document_json(bare).dump();
}

using Values = std::set<std::pair<std::string, std::string>>;

void collect(const Node& node, Values& values) {
    for (const auto& item : node.items) collect(item, values);
    for (const auto& [key, value] : node.entries) {
        if (is_protected(key.text, value)) {
            values.emplace(key.text, text_of(value));
        }
        collect(value, values);
    }
}

/// One secret of an object, and the keys that decide where it goes.
struct DirectedSecret {
    model::Object object{};
    std::string_view key;
    std::string value;
    std::vector<std::pair<std::string_view, std::string>> direction;  ///< in the order of the field table

    [[nodiscard]] bool has_value_of(const DirectedSecret& other) const {
        return object == other.object && key == other.key && value == other.value;
    }
};

/// The text of a key; empty: it has no value.
std::string text_at(const Node& mapping, std::string_view key) {
    const auto* const value = mapping.find(key);
    return value == nullptr || value->kind == Node::Kind::null ? std::string() : text_of(*value);
}

void collect_secrets_of(const Node& mapping, model::Object object, std::vector<DirectedSecret>& secrets) {
    for (const auto& field : model::fields(object)) {
        if (!field.secret) continue;
        auto value = text_at(mapping, field.key);
        if (value.empty()) continue;
        DirectedSecret secret{object, field.key, std::move(value), {}};
        for (const auto& other : model::fields(object))
            if (other.directs_secret) secret.direction.emplace_back(other.key, text_at(mapping, other.key));
        secrets.push_back(std::move(secret));
    }
}

/// Any mapping may be any object here: a secret in a wrong place is compared too.
void collect_secrets(const Node& node, std::vector<DirectedSecret>& secrets) {
    if (node.kind == Node::Kind::mapping)
        for (const auto object : model::kObjects) collect_secrets_of(node, object, secrets);
    for (const auto& item : node.items) collect_secrets(item, secrets);
    for (const auto& entry : node.entries) collect_secrets(entry.value, secrets);
}

/// The keys that differ between two directions of one object.
std::vector<std::string_view> differing_keys(const DirectedSecret& a, const DirectedSecret& b) {
    std::vector<std::string_view> keys;
    for (std::size_t i = 0; i < a.direction.size(); ++i)
        if (a.direction[i] != b.direction[i]) keys.push_back(a.direction[i].first);
    return keys;
}

/// The first key that sends `secret` elsewhere than each secret of `before` with the same value does.
std::string_view redirecting_key(const DirectedSecret& secret, const std::vector<DirectedSecret>& before) {
    std::vector<std::string_view> fewest;
    for (const auto& old : before) {
        if (!secret.has_value_of(old)) continue;
        auto keys = differing_keys(secret, old);
        if (keys.empty()) return {};
        if (fewest.empty() || keys.size() < fewest.size()) fewest = std::move(keys);
    }
    // A secret that the file does not have belongs to the author of the change.
    return fewest.empty() ? std::string_view() : fewest.front();
}

/// The names of tables and templates.
void collect_files(const Node& node, std::set<std::string>& names) {
    for (const auto& item : node.items) collect_files(item, names);
    for (const auto& [key, value] : node.entries) {
        const bool named = key.text == "variables" || key.text == "locals" || key.text == "device_template";
        if (named && value.kind == Node::Kind::scalar) names.insert(value.text);
        collect_files(value, names);
    }
}

bool is_table(const std::filesystem::path& path) {
    constexpr std::array<std::string_view, 4> kEndings{".csv", ".tsv", ".yaml", ".yml"};
    return std::ranges::find(kEndings, path.extension().string()) != kEndings.end();
}

bool is_inside(const std::filesystem::path& folder, const std::filesystem::path& path) {
    std::error_code trouble;
    const auto outer = std::filesystem::weakly_canonical(folder.empty() ? "." : folder, trouble);
    if (trouble) return false;
    const auto inner = std::filesystem::weakly_canonical(path, trouble);
    if (trouble) return false;
    const auto [end, rest] = std::ranges::mismatch(outer, inner);
    return end == outer.end();
}

}  // namespace

std::string new_protected_key(const Node& old, const Node& wanted) {
    Values before;
    Values after;
    collect(old, before);
    collect(wanted, after);
    for (const auto& value : after)
        if (!before.contains(value)) return value.first;
    return {};
}

std::string redirecting_key(const Node& old, const Node& wanted) {
    std::vector<DirectedSecret> before;
    std::vector<DirectedSecret> after;
    collect_secrets(old, before);
    collect_secrets(wanted, after);
    for (const auto& secret : after)
        if (const auto key = redirecting_key(secret, before); !key.empty()) return std::string(key);
    return {};
}

file::Reader restricted_reader(const std::string& project_file, const Node& saved) {
    const auto folder = std::filesystem::path(project_file).parent_path();
    std::set<std::string> names;
    collect_files(saved, names);
    std::set<std::string> allowed;
    for (const auto& name : names) allowed.insert((folder / name).lexically_normal().string());
    return [folder, allowed = std::move(allowed),
            read = file::file_reader()](const std::string& path) -> Result<std::string> {
        if (allowed.contains(path) || (is_table(path) && is_inside(folder, path))) return read(path);
        return fail(Code::cannot_open, path, EACCES);
    };
}

}  // namespace takt::web
