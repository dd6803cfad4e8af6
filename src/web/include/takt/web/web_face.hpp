// The page and the API of a running project: everything behind one address.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "takt/web/host_access.hpp"
#include "takt/web/web_server.hpp"

namespace takt::web {

struct WebFaceOptions {
    WebServerOptions server;
    HostAccess host;
    std::string project;  ///< its name for people
    std::string version;  ///< of the program
    bool demo = false;
    bool editable = false;  ///< the project can be saved: PUT /project works
    bool history = false;   ///< the project has a history
    /// Keeps the marks of trends while the project has a history: marks_file(). Empty: they are in memory.
    std::string marks_file = {};
    std::vector<ApiRoute> routes = {};  ///< further ones
};

/// A face of a host like every other: it has sessions, and nothing that it does holds up the I/O thread.
class WebFace {
public:
    /// @returns as WebServer::start()
    [[nodiscard]] static Result<std::unique_ptr<WebFace>> start(WebFaceOptions options);
    /// stop(), and waits for requests that are being executed.
    ~WebFace();
    WebFace(const WebFace&) = delete;
    WebFace& operator=(const WebFace&) = delete;

    /// Ends all streams, and requests as WebServer::stop() does. Before the host stops.
    /// @returns whether all requests have ended. If not, threads still use the host
    bool stop();

    [[nodiscard]] std::string url() const;

private:
    struct Impl;
    explicit WebFace(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace takt::web
