// From a request to the text of its answer.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "http/forwarding.hpp"
#include "http/http_connection.hpp"
#include "http/reply_text.hpp"
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

    /// Applies the rules to a request without its body, and fills in what is known when it is admitted;
    /// client and visitor also of one that is refused. Takes some 20 us.
    /// @returns the answer to a request that is refused
    [[nodiscard]] std::optional<HttpReply> admit(HttpRequest& request) const;

    /// Executes a request that was admitted. Blocks for as long as the handler does.
    [[nodiscard]] HttpReply reply(HttpRequest request) const;

private:
    [[nodiscard]] GuardedRequest guarded(const RequestHead& head, const ForwardedClient& client) const;
    [[nodiscard]] const ApiRoute* route_of(const RequestHead& head) const;
    [[nodiscard]] const StreamRoute* stream_of(const RequestHead& head) const;
    [[nodiscard]] report::Texts texts_of(const RequestHead& head) const;
    [[nodiscard]] HttpReply serve_page(const RequestHead& head) const;
    [[nodiscard]] HttpReply serve_api(HttpRequest request) const;
    [[nodiscard]] HttpReply refuse(const RequestHead& head, const Refusal& why,
                                   ReplyFields fields = {}) const;
    [[nodiscard]] ApiResponse execute(const ApiRoute& route, const ApiRequest& request) const;

    RequestGuard guard_;
    std::vector<Network> proxies_;
    text::Language language_;
    std::vector<ApiRoute> routes_;
    std::vector<StreamRoute> streams_;
    Log log_;
};

}  // namespace takt::web
