#include "live/state_api.hpp"

#include <utility>
#include <variant>

#include "live/live_hub.hpp"
#include "live/live_values.hpp"
#include "live/requests_json.hpp"
#include "live/wall_time.hpp"
#include "live/why.hpp"
#include "takt/plan/learning.hpp"
#include "takt/report/drawing/value_json.hpp"
#include "takt/report/states/learnt_report.hpp"
#include "takt/report/states/state_report.hpp"

namespace takt::web {
namespace {

ApiResponse info_response(const HostAccess& host, const ProgramInfo& info) {
    auto object = file::Json::object();
    object.set("project", info.project);
    object.set("version", info.version);
    object.set("started", utc_text(host.started));
    object.set("now", utc_text(line::now()));
    object.set("demo", info.demo);
    object.set("allow_write", info.allow_write);
    object.set("editable", info.editable);
    object.set("history", info.history);
    object.set("generation", host.configuration()->generation());
    return ApiResponse::json(object);
}

ApiResponse status_response(const HostAccess& host, const ApiRequest& request) {
    const auto snapshot = take_snapshot(host, {.values = true, .statistics = true});
    if (!snapshot) return host_error(request, snapshot.error());
    return ApiResponse::json(status_object(request.texts, *snapshot, host));
}

/// Sets `raw` of each value that is in registers.
void add_registers(file::Json& object, const host::Snapshot& snapshot) {
    const auto& configuration = *snapshot.configuration;
    auto values = std::get<file::Json::Array>(object.find("values")->value());
    for (auto& value : values) {
        const auto slot = configuration.find(std::get<std::string>(value.find("name")->value()));
        const auto* const variable = slot ? configuration.variable_of(*slot) : nullptr;
        if (!variable) continue;
        if (auto raw = raw_json(*variable, snapshot.values[slot->value].value); !raw.is_null())
            value.set("raw", std::move(raw));
    }
    object.set("values", file::Json(std::move(values)));
}

ApiResponse values_response(const HostAccess& host, const ApiRequest& request) {
    const auto snapshot = take_snapshot(host, {.values = true, .statistics = true});
    if (!snapshot) return host_error(request, snapshot.error());
    auto object = report::values_json(*snapshot, utc_text(snapshot->t), request.parameter("pattern"));
    if (request.parameter("raw") == "1") add_registers(object, *snapshot);
    return ApiResponse::json(object);
}

ApiResponse requests_response(const HostAccess& host, const ApiRequest& request) {
    const auto snapshot =
        take_snapshot(host, {.values = false, .statistics = true, .times = true, .plan = true});
    if (!snapshot) return host_error(request, snapshot.error());
    return ApiResponse::json(requests_json(*snapshot));
}

/// What the devices with `gaps: learn` were found to answer and to refuse.
ApiResponse learnt_response(const HostAccess& host, const ApiRequest& request) {
    const auto snapshot = take_snapshot(host, {.values = false, .learnt = true});
    if (!snapshot) return host_error(request, snapshot.error());
    auto project = snapshot->configuration->project();
    auto lines = file::Json::array();
    for (std::size_t l = 0; l < project.lines.size() && l < snapshot->lines.size(); ++l) {
        auto& line = project.lines[l];
        for (std::size_t d = 0; d < snapshot->lines[l].learnt.size() && d < line.devices.size(); ++d)
            line.devices[d].learnt = snapshot->lines[l].learnt[d];
        auto object = file::Json::object();
        object.set("name", line.name);
        object.set("learns", plan::learns(line));
        object.set("learnt", report::learnt_json(project, l));
        lines.push_back(std::move(object));
    }
    auto object = file::Json::object();
    object.set("time", utc_text(snapshot->t));
    object.set("lines", std::move(lines));
    return ApiResponse::json(object);
}

ApiResponse why_response(const HostAccess& host, const ApiRequest& request) {
    const auto snapshot = take_snapshot(host, {.values = true, .statistics = true, .plan = true});
    if (!snapshot) return host_error(request, snapshot.error());
    const auto slot = snapshot->configuration->find(request.parameter("variable"));
    if (!slot) {
        return ApiResponse::error(
            404, "variable",
            request.texts("web.error.variable", {{"name", std::string(request.parameter("variable"))}}));
    }
    return ApiResponse::json(why_json(request.texts, *snapshot, *slot));
}

}  // namespace

Result<host::Snapshot> take_snapshot(const HostAccess& host, const host::SnapshotParts& parts) {
    TAKT_TRY(const auto session, host.open_session({.events = false}));
    return session->snapshot(parts, std::chrono::seconds(3));
}

ApiResponse malformed_body(const ApiRequest& request) {
    return ApiResponse::error(400, "body", request.texts("web.error.body"));
}

ApiResponse host_error(const ApiRequest& request, const Error& error) {
    return ApiResponse::error(503, name(error.code), request.texts.describe(error));
}

std::vector<ApiRoute> state_routes(const HostAccess& host, const ProgramInfo& info) {
    using enum Method;
    return {
        {get, "/info", false, [&](const ApiRequest&) { return info_response(host, info); }},
        {get, "/status", false, [&](const ApiRequest& request) { return status_response(host, request); }},
        {get, "/values", false, [&](const ApiRequest& request) { return values_response(host, request); }},
        {get, "/requests", false,
         [&](const ApiRequest& request) { return requests_response(host, request); }},
        {get, "/devices/learnt", false,
         [&](const ApiRequest& request) { return learnt_response(host, request); }},
        {get, "/why", false, [&](const ApiRequest& request) { return why_response(host, request); }},
    };
}

}  // namespace takt::web
