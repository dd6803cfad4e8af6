// Text of requests to text of answers: what HTTP means is left to cpp-httplib, on memory instead of a socket.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "http_connection.hpp"
#include "request_guard.hpp"
#include "takt/base/log.hpp"
#include "takt/web/api.hpp"
#include "takt/web/web_server.hpp"

namespace takt::web {

/// Finds the route of a request, applies the rules, and executes its handler. Any thread; several at once.
class HttpRouter {
public:
    HttpRouter(GuardPolicy policy, text::Language language, std::vector<ApiRoute> routes,
               std::vector<StreamRoute> streams, Log log);
    ~HttpRouter();
    HttpRouter(const HttpRouter&) = delete;
    HttpRouter& operator=(const HttpRouter&) = delete;

    /// Blocks for as long as the handler does.
    [[nodiscard]] HttpReply reply(HttpRequest request) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace takt::web
