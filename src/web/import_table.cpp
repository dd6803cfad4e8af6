#include "import_table.hpp"

#include <array>

#include "takt/file/convert.hpp"
#include "takt/file/load.hpp"
#include "takt/file/table.hpp"
#include "takt/report/findings_report.hpp"

namespace takt::web {
namespace {

using file::Json;

constexpr std::array<std::string_view, 5> kKinds{"variables", "locals", "served", "list", "devices"};

Json rows_json(const model::Node& rows, file::TableKind kind) {
    Json::Array all;
    for (const auto& its : rows.items) {
        const auto row = kind == file::TableKind::devices ? file::device_settings(its) : its;
        Json::Object cells;
        for (const auto& [key, value] : row.entries)
            cells.emplace_back(key.text, value.kind == model::Node::Kind::list
                                             ? rows_json(value, file::TableKind::variables)
                                             : Json(value.text));
        all.emplace_back(std::move(cells));
    }
    return Json(std::move(all));
}

}  // namespace

ApiResponse import_table(const ApiRequest& request) {
    const auto body = Json::parse(request.body, file::kMaxFileBytes);
    const auto* const value = body ? body->find("text") : nullptr;
    const auto* const text = value == nullptr ? nullptr : std::get_if<std::string>(&value->value());
    if (text == nullptr)
        return ApiResponse::error(400, "malformed",
                                  request.texts("web.project.malformed", {{"subject", "text"}}));
    const auto read = file::load_tables_text({{request.texts("web.import.name"), *text}},
                                             {.addresses = file::Addresses::automatic, .devices = true});
    const auto& table = read.tables.front();
    auto object = Json::object();
    object.set("kind", kKinds[static_cast<std::size_t>(table.kind)]);
    object.set("rows", rows_json(table.rows, table.kind));
    object.set("findings",
               report::findings_json(request.texts, read.loaded.document.files, read.loaded.findings));
    return ApiResponse::json(object, read.loaded.readable ? 200 : 422);
}

}  // namespace takt::web
