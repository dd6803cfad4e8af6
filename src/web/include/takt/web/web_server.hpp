// The HTTP server of a running project.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/log.hpp"
#include "takt/base/network.hpp"
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
    std::vector<std::string> names = {};                ///< further ones of this machine, in lower case
    std::vector<Network> proxies = {};                  ///< whose fields X-Forwarded-* count
    std::string token = {};                             ///< needed for the API; empty: none
    bool allow_write = false;                           ///< routes that change something work
    text::Language language = text::Language::english;  ///< of requests that name none
    Log log{};
    // Of all visitors: beyond them the answer is 503.
    std::size_t connections = 256;    ///< one beyond replaces an idle one
    std::size_t threads = 8;          ///< for requests that are quick
    std::size_t waiting = 64;         ///< requests without a thread
    std::size_t buffered = 96 << 20;  ///< bytes of bodies and answers, of each visitor at most its share
    // Of one visitor: beyond them the answer is 429, or a connection is closed. A visitor is an address, with
    // and without the token.
    std::size_t visitor_connections = 128;    ///< of an address that is no proxy
    std::size_t visitor_waiting = 16;         ///< requests without a thread
    std::size_t visitor_buffered = 32 << 20;  ///< bytes of bodies and answers
    std::size_t visitor_streams = 16;         ///< open ones
    std::uint32_t burst = 400;                ///< requests at once
    std::uint32_t requests_per_second = 100;  ///< in the mean
};

/// Serves the page, the routes below /api/v1 and the streams.
///
/// Threads: one moves the bytes of all connections and never waits for a browser; others execute requests,
/// some for each kind of work (RequestQueue). A request that waits, and a browser that reads slowly, hold a
/// connection and memory, no thread.
class WebServer {
public:
    /// @returns cannot_open (host:port, errno), as line::TcpServer::listen()
    [[nodiscard]] static Result<std::unique_ptr<WebServer>> start(const WebServerOptions& options,
                                                                  std::vector<ApiRoute> routes,
                                                                  std::vector<StreamRoute> streams);
    /// stop(), and waits for requests that are being executed.
    ~WebServer();
    WebServer(const WebServer&) = delete;
    WebServer& operator=(const WebServer&) = delete;

    /// Closes all connections, stops requests that are being executed (ApiRequest::stop), and waits for them
    /// for kStopLimit at most.
    /// @returns whether they have all ended. If not, threads still use the routes
    bool stop();
    static constexpr auto kStopLimit = std::chrono::milliseconds(500);

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

/// Parses a name under which browsers reach the page: "plant.example.com", "vm.local", or an address, without
/// scheme and port. @returns it in lower case; nothing: it is not valid
[[nodiscard]] std::optional<std::string> parse_web_name(std::string_view text);

/// Whether other computers can reach the address: it is not one of the loopback interface.
[[nodiscard]] bool needs_token(const line::ListenAddress& address);

}  // namespace takt::web
