// The HTTP server of a running project.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/log.hpp"
#include "takt/base/result.hpp"
#include "takt/line/target.hpp"
#include "takt/web/api.hpp"
#include "takt/web/stream.hpp"

namespace takt::web {

/// A stream of server-sent events.
struct StreamRoute {
    std::string_view path;  ///< below /api/v1
    /// On a thread of the server. @returns nullptr: too many streams are open
    std::function<std::unique_ptr<StreamSource>(const ApiRequest&)> open;
};

struct WebServerOptions {
    line::ListenAddress address{"127.0.0.1", 8502};
    std::string token = {};                             ///< needed for the API; empty: none
    bool allow_write = false;                           ///< routes that change something work
    text::Language language = text::Language::english;  ///< of requests that name none
    Log log{};
    std::size_t connections = 256;            ///< one beyond replaces an idle one, or is answered with 503
    std::size_t threads = 8;                  ///< that execute requests
    std::size_t waiting = 64;                 ///< requests without a thread; beyond: 503
    std::size_t buffered = 96 << 20;          ///< bytes of bodies and answers of all connections
    std::uint32_t burst = 400;                ///< requests of one address at once
    std::uint32_t requests_per_second = 100;  ///< of one address in the mean; beyond: 429
};

/// Serves the page, the routes below /api/v1 and the streams.
///
/// Threads: one moves the bytes of all connections and never waits for a browser; `threads` execute requests.
/// A browser that reads slowly holds a connection and the answer's memory, no thread.
class WebServer {
public:
    /// @returns cannot_open (host:port, errno), as line::TcpServer::listen()
    [[nodiscard]] static Result<std::unique_ptr<WebServer>> start(const WebServerOptions& options,
                                                                  std::vector<ApiRoute> routes,
                                                                  std::vector<StreamRoute> streams);
    /// stop()
    ~WebServer();
    WebServer(const WebServer&) = delete;
    WebServer& operator=(const WebServer&) = delete;

    /// Closes all connections and waits for requests that are being executed. A second call does nothing.
    void stop();

    [[nodiscard]] std::uint16_t port() const;
    /// "http://127.0.0.1:8502/"; of all addresses that of the loopback interface.
    [[nodiscard]] std::string url() const;

    /// Streams have something to send. Any thread, also after stop().
    void poke();

private:
    struct Impl;
    explicit WebServer(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

/// Whether other computers can reach the address: it is not one of the loopback interface.
[[nodiscard]] bool needs_token(const line::ListenAddress& address);

}  // namespace takt::web
