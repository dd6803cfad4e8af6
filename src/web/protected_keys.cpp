#include "protected_keys.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <set>
#include <string_view>
#include <utility>

#include "takt/file/document_json.hpp"

namespace takt::web {
namespace {

using model::Node;

constexpr std::array<std::string_view, 11> kProtected{
    "command",          "run",      "audit",     "state", "password_file", "password_env", "ca_file",
    "certificate_file", "key_file", "directory", "path"};

/// `file` is a mapping in the source of a variable, and a name in a replay.
bool is_protected(std::string_view key, const Node& value) {
    if (key == "file") return value.kind == Node::Kind::scalar;
    return std::ranges::find(kProtected, key) != kProtected.end();
}

using Values = std::set<std::pair<std::string, std::string>>;

void collect(const Node& node, Values& values) {
    for (const auto& item : node.items) collect(item, values);
    for (const auto& [key, value] : node.entries) {
        if (is_protected(key.text, value)) {
            auto bare = value;
            file::without_origins(bare);
            values.emplace(key.text, file::document_json(bare).dump());
        }
        collect(value, values);
    }
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
