// Text of requests to text of answers: what HTTP means is left to cpp-httplib, on memory instead of a socket.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "http/http_connection.hpp"
#include "http/request_guard.hpp"
#include "takt/base/log.hpp"
#include "takt/base/network.hpp"
#include "takt/web/api.hpp"
#include "takt/web/web_server.hpp"

namespace takt::web {

/// Finds the route of a request, applies the rules, and executes its handler. Any thread; several at once.
class HttpRouter {
public:
    /// @param proxies  whose fields X-Forwarded-* count
    HttpRouter(GuardPolicy policy, std::vector<Network> proxies, text::Language language,
               std::vector<ApiRoute> routes, std::vector<StreamRoute> streams, Log log);
    ~HttpRouter();
    HttpRouter(const HttpRouter&) = delete;
    HttpRouter& operator=(const HttpRouter&) = delete;

    /// Applies the rules to a request without its body, and fills in what is known when it is admitted; the
    /// visitor also of one that is refused. Takes some 20 us.
    /// @returns the answer to a request that is refused
    [[nodiscard]] std::optional<HttpReply> admit(HttpRequest& request) const;

    /// Applies the rules and executes. Blocks for as long as the handler does.
    [[nodiscard]] HttpReply reply(HttpRequest request) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace takt::web
