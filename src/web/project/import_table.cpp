#include "project/import_table.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "takt/file/convert.hpp"
#include "takt/file/json_members.hpp"
#include "takt/file/load.hpp"
#include "takt/file/table.hpp"
#include "takt/model/findings.hpp"
#include "takt/report/plans/findings_report.hpp"

namespace takt::web {
namespace {

using file::Json;

constexpr std::array<std::string_view, 5> kKinds{"variables", "locals", "served", "list", "devices"};

Json row_json(const model::Node& row) {
    Json::Object cells;
    for (const auto& [key, value] : row.entries) {
        auto cell = Json(value.text);
        if (value.kind == model::Node::Kind::list) {
            cell = Json::array();
            for (const auto& its : value.items) cell.push_back(row_json(its));
        }
        cells.emplace_back(key.text, std::move(cell));
    }
    return Json(std::move(cells));
}

Json rows_json(const model::Node& rows, file::TableKind kind) {
    auto all = Json::array();
    for (const auto& its : rows.items)
        all.push_back(row_json(kind == file::TableKind::devices ? file::device_settings(its) : its));
    return all;
}

/// Nothing: this is no list of texts alone.
std::optional<std::vector<std::string>> texts_of(const Json& list) {
    if (!std::holds_alternative<Json::Array>(list.value())) return std::nullopt;
    std::vector<std::string> texts;
    for (const auto& its : items_of(list)) {
        const auto* const text = text_in(its);
        if (text == nullptr) return std::nullopt;
        texts.push_back(*text);
    }
    return texts;
}

/// The rows of cells without headings; nothing: the body is malformed.
std::optional<Json> rows_of_cells(const Json& body) {
    const auto keys = texts_of(member(body, "keys"));
    const auto& cells = member(body, "cells");
    if (!keys || !std::holds_alternative<Json::Array>(cells.value())) return std::nullopt;
    auto rows = Json::array();
    for (const auto& its : items_of(cells)) {
        const auto texts = texts_of(its);
        if (!texts || texts->size() > keys->size()) return std::nullopt;
        std::vector<std::pair<std::string, std::string>> row;
        for (std::size_t i = 0; i < texts->size(); ++i) row.emplace_back((*keys)[i], (*texts)[i]);
        const auto read = file::read_row(row);
        rows.push_back(read ? row_json(*read) : Json());
    }
    return rows;
}

/// What the pasted rows get from the project that they are for.
file::Surroundings surroundings_of(const Json& body) {
    const auto transport = string_member(body, "transport", "serial");
    file::Surroundings around{{{"name", "line"}, {"transport", transport}}, {{"address", "1"}}};
    if (transport != "simulated") around.line.emplace_back(transport == "serial" ? "port" : "host", "-");
    for (auto& name : strings_member(body, "names")) around.names.insert(std::move(name));
    return around;
}

/// The devices of the one line; nullptr: there are none, or several lines.
const model::Node* devices_of(const model::Node& project) {
    const auto* const lines = project.find("lines");
    return lines == nullptr || lines->items.size() != 1 ? nullptr : lines->items.front().find("devices");
}

/// The rows with the names that their variables get in a project. Rows that name their devices become these.
void take_names(file::LoadedTables::Table& table, const model::Node& devices) {
    const auto variables_of = [](model::Node& row) {
        const auto is_it = [](const auto& entry) { return entry.key.text == "variables"; };
        const auto found = std::ranges::find_if(row.entries, is_it);
        return found == row.entries.end() ? nullptr : &found->value;
    };
    using Kind = file::TableKind;
    if (table.kind == Kind::devices) {
        for (std::size_t i = 0; i < std::min(table.rows.items.size(), devices.items.size()); ++i)
            if (auto* const list = variables_of(table.rows.items[i]))
                *list = *devices.items[i].find("variables");
    } else if (table.kind == Kind::variables || table.kind == Kind::list) {
        const bool placed = std::ranges::any_of(table.rows.items, [](const auto& row) {
            return row.find(file::kDeviceColumn) != nullptr || row.find(file::kUnitAddressColumn) != nullptr;
        });
        if (placed)
            table = {devices, Kind::devices};
        else if (devices.items.size() == 1)
            table.rows = *devices.items.front().find("variables");
    }
}

ApiResponse malformed(const ApiRequest& request, const char* subject) {
    return ApiResponse::error(400, "malformed",
                              request.texts("web.project.malformed", {{"subject", subject}}));
}

ApiResponse import_cells(const ApiRequest& request, const Json& body) {
    auto rows = rows_of_cells(body);
    if (!rows) return malformed(request, "cells");
    auto object = Json::object();
    object.set("rows", *std::move(rows));
    return ApiResponse::json(object);
}

}  // namespace

ApiResponse import_table(const ApiRequest& request) {
    const auto body = Json::parse(request.body, file::kMaxFileBytes);
    if (body && body->find("cells") != nullptr) return import_cells(request, *body);
    const auto* const text = body ? text_in(member(*body, "text")) : nullptr;
    if (text == nullptr) return malformed(request, "text");
    auto read = file::load_tables_text({{request.texts("web.import.name"), *text}},
                                       {.addresses = file::Addresses::automatic, .devices = true});
    auto table = read.tables.front();
    auto project = file::project_of_tables(std::move(read), surroundings_of(*body),
                                           {string_member(*body, "device", "-")});
    if (project.readable)
        if (const auto* const devices = devices_of(project.document.root)) take_names(table, *devices);
    const auto profile = string_member(*body, "profile", "");
    if (!profile.empty())
        project.document.root.entries.push_back({{.kind = model::Node::Kind::scalar, .text = "profile"},
                                                 {.kind = model::Node::Kind::scalar, .text = profile}});
    auto findings = std::move(project.findings);
    if (project.readable)
        std::ranges::move(model::interpret(project.document).findings, std::back_inserter(findings));
    // What is not in the table is in the project that the rows are for.
    std::erase_if(findings, [](const auto& its) { return its.location.file == 0; });
    std::ranges::stable_sort(findings, {}, [](const auto& its) { return its.location.line; });
    auto object = Json::object();
    object.set("kind", kKinds[static_cast<std::size_t>(table.kind)]);
    object.set("rows", rows_json(table.rows, table.kind));
    object.set("findings", report::findings_json(request.texts, project.document.files, findings));
    return ApiResponse::json(object, project.readable ? 200 : 422);
}

}  // namespace takt::web
