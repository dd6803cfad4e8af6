#include "project/project_parts.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <functional>

namespace takt::web {
namespace {

using file::Json;
using model::Node;

/// An object with a list of variables: a device or a unit.
using Visit = std::function<void(const std::string& path, const Node& alone, const Node& complete)>;

const Node* list_at(const Node& mapping, std::string_view key) {
    const auto* const value = mapping.find(key);
    return value != nullptr && value->kind == Node::Kind::list ? value : nullptr;
}

void visit_parts(const Node& alone, const Node& complete, std::string_view outer, std::string_view inner,
                 const Visit& visit) {
    const auto* const owners = list_at(alone, outer);
    const auto* const whole_owners = list_at(complete, outer);
    if (owners == nullptr || whole_owners == nullptr) return;
    for (std::size_t i = 0; i < std::min(owners->items.size(), whole_owners->items.size()); ++i) {
        const auto* const parts = list_at(owners->items[i], inner);
        const auto* const whole_parts = list_at(whole_owners->items[i], inner);
        if (parts == nullptr || whole_parts == nullptr) continue;
        for (std::size_t j = 0; j < std::min(parts->items.size(), whole_parts->items.size()); ++j)
            visit(std::string(outer) + '[' + std::to_string(i) + "]." + std::string(inner) + '[' +
                      std::to_string(j) + ']',
                  parts->items[j], whole_parts->items[j]);
    }
}

std::size_t count_of(const Node* list) {
    return list == nullptr ? 0 : list->items.size();
}

Json list_rows(const Node* list, std::size_t count) {
    Json::Array rows;
    for (std::size_t i = 0; i < std::min(count, count_of(list)); ++i) {
        auto row = Json::object();
        for (const auto& [key, value] : list->items[i].entries)
            if (value.kind == Node::Kind::scalar) row.set(key.text, value.text);
        rows.push_back(std::move(row));
    }
    return Json(std::move(rows));
}

}  // namespace

Json read_only_parts(const Node& alone, const Node& complete, const std::string& project_file) {
    auto parts = Json::array();
    const auto folder = std::filesystem::path(project_file).parent_path();
    const auto add = [&](const std::string& path, const Node* name, const Node* list, std::size_t count) {
        if (name == nullptr || name->kind != Node::Kind::scalar) return;
        auto part = Json::object();
        part.set("path", path);
        part.set("file", (folder / name->text).lexically_normal().string());
        part.set("rows", list_rows(list, count));
        parts.push_back(std::move(part));
    };
    const Visit visit = [&](const std::string& path, const Node& own, const Node& whole) {
        const auto* const list = list_at(whole, "variables");
        add(path + ".variables", own.find("variables"), list, count_of(list));
        const auto* const mine = list_at(own, "variables");
        add(path + ".device_template", own.find("device_template"), list, count_of(list) - count_of(mine));
    };
    visit_parts(alone, complete, "lines", "devices", visit);
    visit_parts(alone, complete, "servers", "units", visit);
    const auto* const locals = list_at(complete, "locals");
    add("locals", alone.find("locals"), locals, count_of(locals));
    return parts;
}

TemplateParts::TemplateParts(const Node& alone, const Node& complete) {
    visit_parts(alone, complete, "lines", "devices",
                [this](const std::string& path, const Node& own, const Node& whole) {
                    const auto mine = count_of(list_at(own, "variables"));
                    const auto all = count_of(list_at(whole, "variables"));
                    if (own.find("device_template") != nullptr && all > mine)
                        counts_.emplace_back(path, all - mine);
                });
}

void TemplateParts::correct(std::vector<model::Finding>& findings) const {
    constexpr std::string_view kList = ".variables[";
    for (auto& finding : findings)
        for (const auto& [device, count] : counts_) {
            const std::string_view path = finding.path;
            if (!path.starts_with(device) || !path.substr(device.size()).starts_with(kList)) continue;
            const auto digits = path.substr(device.size() + kList.size());
            std::size_t index = 0;
            const auto end = std::from_chars(digits.data(), digits.data() + digits.size(), index).ptr;
            const std::string rest(end, digits.data() + digits.size());
            finding.path = index < count ? device + ".device_template"
                                         : device + std::string(kList) + std::to_string(index - count) + rest;
            break;
        }
}

}  // namespace takt::web
