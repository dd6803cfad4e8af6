#include "takt/web/web_server.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "http_connection.hpp"
#include "http_router.hpp"
#include "request_guard.hpp"
#include "takt/line/loop.hpp"
#include "takt/line/tcp_server.hpp"
#include "takt/os/worker.hpp"

namespace takt::web {
namespace {

// Connections that are accepted beyond the limit, so that their requests are answered with 503 if no other
// connection has been idle for so long.
constexpr std::size_t kAnsweredWith503 = 64;
constexpr Duration kEvictAfter = std::chrono::seconds(2);

std::vector<std::string> machine_names() {
    std::array<char, 256> name{};
    if (::gethostname(name.data(), name.size() - 1) != 0 || name[0] == '\0') return {};
    return {host_name(name.data()).value_or("localhost")};
}

GuardPolicy policy_of(const WebServerOptions& options) {
    return {.address = options.address.host,
            .names = machine_names(),
            .token = options.token,
            .allow_write = options.allow_write};
}

}  // namespace

// Reached from the server's thread, from the workers and from producers of events. It outlives the loop's
// last task, and poke() after stop() finds no loop any more.
struct WebServer::Impl {
    Impl(const WebServerOptions& with, std::vector<ApiRoute> routes, std::vector<StreamRoute> streams)
        : options(with),
          router(policy_of(with), with.language, std::move(routes), std::move(streams), with.log),
          rates(with.burst, std::chrono::nanoseconds(std::chrono::seconds(1)) / with.requests_per_second) {}

    WebServerOptions options;
    HttpRouter router;
    PeerRates rates;
    std::unique_ptr<line::Loop> loop;
    std::unique_ptr<os::Worker> worker;
    std::map<std::uint64_t, HttpConnection*> connections;  // of the server's thread
    std::uint64_t last_connection = 0;
    std::size_t buffered = 0;
    std::unique_ptr<line::TcpServer> server;
    std::thread thread;
    std::uint16_t port = 0;
    std::atomic<bool> poked = false;
    std::atomic<bool> stopping = false;
    std::mutex stop_mutex;  // poke() against stop()

    Result<void> begin() {
        TAKT_TRY(loop, line::Loop::create());
        worker = std::make_unique<os::Worker>(os::Worker::Options{
            .threads = options.threads, .queue = options.waiting, .at_end = os::Worker::AtEnd::discard});
        line::TcpServerOptions serving;
        serving.max_connections = options.connections + kAnsweredWith503;
        serving.evict_after = kEvictAfter;
        serving.log = options.log;
        TAKT_TRY(server, line::TcpServer::listen(
                             *loop, options.address,
                             [this](Instant t, std::string_view peer) { return accept(t, peer); }, serving));
        port = server->port();
        thread = std::thread([this] { loop->run(); });
        return {};
    }

    std::unique_ptr<line::Session> accept(Instant t, std::string_view peer) {
        const auto id = ++last_connection;
        auto connection = std::make_unique<HttpConnection>(
            HttpConnection::Limits{}, peer, t,
            [this, id](HttpConnection&, HttpRequest request) { return execute(id, std::move(request)); },
            [this](std::ptrdiff_t change) {
                buffered += static_cast<std::size_t>(change);
                return buffered <= options.buffered;
            },
            [this, id] { connections.erase(id); });
        connections.emplace(id, connection.get());
        return connection;
    }

    // Closes the connections beyond the limit that have been idle for the longest time.
    void evict() {
        if (connections.size() <= options.connections) return;
        std::vector<std::pair<Instant, HttpConnection*>> idle;
        for (const auto& [id, connection] : connections)
            if (const auto since = connection->waits_since(); since && line::now() - *since >= kEvictAfter)
                idle.emplace_back(*since, connection);
        std::ranges::sort(idle);
        idle.resize(std::min(idle.size(), connections.size() - options.connections));
        for (const auto& [since, connection] : idle) connection->drop();
    }

    int execute(std::uint64_t id, HttpRequest request) {
        if (!rates.admit(request.peer, line::now())) return 429;
        auto shared = std::make_shared<HttpRequest>(std::move(request));
        if (connections.size() <= options.connections) return start(id, std::move(shared));
        // Others cannot be closed here, in the middle of a call of this connection's engine.
        loop->post([this, id, shared] {
            evict();
            const bool admitted = connections.size() <= options.connections;
            if (const int status = admitted ? start(id, shared) : 503; status != 0)
                answer(id, {.bytes = bare_reply(status), .close = true});
        });
        return 0;
    }

    // @returns 0, or the status where no thread takes it
    int start(std::uint64_t id, std::shared_ptr<HttpRequest> request) {
        const bool posted = worker->post([this, id, request = std::move(request)] {
            auto reply = std::make_shared<HttpReply>(router.reply(std::move(*request)));
            loop->post([this, id, reply] { answer(id, std::move(*reply)); });
        });
        return posted ? 0 : 503;
    }

    void answer(std::uint64_t id, HttpReply reply) {
        const auto found = connections.find(id);
        if (found == connections.end()) return;  // the browser has gone
        found->second->answer(line::now(), std::move(reply));
        found->second->poke();
    }

    void poke() {
        if (poked.exchange(true)) return;
        const std::lock_guard lock(stop_mutex);
        if (stopping) return;
        loop->post([this] {
            poked = false;
            // A poke may end the connection, and so take it out of the map.
            for (auto next = connections.begin(); next != connections.end();) {
                const auto* const connection = (next++)->second;
                if (connection->streams()) connection->poke();
            }
        });
    }

    void stop() {
        {
            const std::lock_guard lock(stop_mutex);
            if (stopping.exchange(true)) return;
        }
        if (loop) loop->stop();
        if (thread.joinable()) thread.join();
        server.reset();
        worker.reset();  // its jobs post to the loop
        loop.reset();
    }
};

WebServer::WebServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
WebServer::~WebServer() {
    impl_->stop();
}

Result<std::unique_ptr<WebServer>> WebServer::start(const WebServerOptions& options,
                                                    std::vector<ApiRoute> routes,
                                                    std::vector<StreamRoute> streams) {
    std::unique_ptr<WebServer> server(
        new WebServer(std::make_unique<Impl>(options, std::move(routes), std::move(streams))));
    TAKT_CHECK(server->impl_->begin());
    return server;
}

void WebServer::stop() {
    impl_->stop();
}

void WebServer::poke() {
    impl_->poke();
}

std::uint16_t WebServer::port() const {
    return impl_->port;
}

bool needs_token(const line::ListenAddress& address) {
    return !is_loopback(address.host);
}

std::string WebServer::url() const {
    const auto& host = impl_->options.address.host;
    const bool all = host.empty() || host == "0.0.0.0" || host == "::";
    return "http://" + line::host_and_port(all ? "127.0.0.1" : host, impl_->port) + "/";
}

}  // namespace takt::web
