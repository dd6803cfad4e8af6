// docs/openapi.json against the routes of the server.
#include "http/openapi.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <set>
#include <string>
#include <utility>

#include "devices/command_api.hpp"
#include "devices/search_api.hpp"
#include "live/event_log.hpp"
#include "live/state_api.hpp"
#include "takt/web/history_api.hpp"
#include "takt/web/project_api.hpp"

namespace takt::web {
namespace openapi_test {

file::Json description() {
    return *file::Json::parse(openapi_text());
}

const file::Json::Object& entries(const file::Json& object) {
    return std::get<file::Json::Object>(object.value());
}

std::string_view word(Method method) {
    switch (method) {
        case Method::get: return "get";
        case Method::post: return "post";
        case Method::put: return "put";
    }
    return "";
}

/// Every route with its right: "put /project writes".
std::set<std::string> served() {
    static const HostAccess host;
    static const ProgramInfo info;
    static const std::atomic<bool> stopping = false;
    ProjectApi project({.file = "plant.yaml"});
    std::set<std::string> all{"get /stream",    "get /traffic",      "get /traffic/capture",
                              "get /registers", "get /openapi.json", "get /events"};
    const auto add = [&all](const std::vector<ApiRoute>& routes) {
        for (const auto& route : routes)
            all.insert(std::string(word(route.method)) + ' ' + std::string(route.path) +
                       (route.changes ? " writes" : ""));
    };
    add(state_routes(host, info));
    static Marks marks{0};
    static EventLog log{{.open_session = [](const auto&) { return fail(Code::connection_lost, "host"); }},
                        marks};
    add(command_routes(host, log, stopping));
    DeviceSearch search;
    add(search_routes(search, host));
    add(project.routes());
    add(history_routes({}));
    return all;
}

TEST(OpenApi, DescribesTheRoutesThatAreServed) {
    const auto text = description();
    std::set<std::string> described;
    for (const auto& [path, methods] : entries(*text.find("paths")))
        for (const auto& [method, operation] : entries(methods))
            described.insert(method + ' ' + path + (operation.find("x-needs-allow-write") ? " writes" : ""));
    EXPECT_EQ(described, served());
}

/// Calls `visit` with each "$ref" below a value.
void visit_references(const file::Json& value, const std::function<void(const std::string&)>& visit) {
    if (const auto* const list = std::get_if<file::Json::Array>(&value.value()))
        for (const auto& item : *list) visit_references(item, visit);
    if (!std::holds_alternative<file::Json::Object>(value.value())) return;
    for (const auto& [key, item] : entries(value)) {
        if (key == "$ref") visit(std::get<std::string>(item.value()));
        visit_references(item, visit);
    }
}

TEST(OpenApi, HasWhatItRefersTo) {
    const auto text = description();
    std::size_t count = 0;
    visit_references(text, [&](const std::string& reference) {
        ++count;
        const file::Json* node = &text;
        for (std::size_t at = 2; node && at <= reference.size();) {
            const auto end = std::min(reference.find('/', at), reference.size());
            node = node->find(reference.substr(at, end - at));
            at = end + 1;
        }
        EXPECT_TRUE(node) << reference;
    });
    EXPECT_GT(count, 50u);
}

TEST(OpenApi, DescribesEachAnswer) {
    const auto text = description();
    for (const auto& [path, methods] : entries(*text.find("paths")))
        for (const auto& [method, operation] : entries(methods)) {
            const auto* const done = operation.find("responses")->find("200");
            ASSERT_TRUE(done) << path;
            for (const auto& [media, content] : entries(*done->find("content")))
                EXPECT_TRUE(content.find("schema")) << path << ' ' << media;
            if (method == "get") continue;
            EXPECT_TRUE(operation.find("requestBody")) << path;
            EXPECT_TRUE(operation.find("responses")->find("403")) << path;
        }
}

}  // namespace openapi_test
}  // namespace takt::web
