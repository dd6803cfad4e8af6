#include "takt/web/web_server.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <map>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>

#include "http/buffer_quota.hpp"
#include "http/http_connection.hpp"
#include "http/http_router.hpp"
#include "http/lower_ascii.hpp"
#include "http/reply_text.hpp"
#include "http/request_guard.hpp"
#include "http/request_queue.hpp"
#include "takt/base/assert.hpp"
#include "takt/line/loop.hpp"
#include "takt/line/tcp_server.hpp"
#include "takt/os/thread_name.hpp"
#include "takt/os/worker.hpp"

namespace takt::web {
namespace {

// Connections that are accepted beyond the limit, so that their requests are answered with 503 if no other
// connection has been idle for so long.
constexpr std::size_t kAnsweredWith503 = 64;
constexpr Duration kEvictAfter = std::chrono::seconds(2);

/// The machine's name and those of the options.
std::vector<std::string> names_of(const WebServerOptions& options) {
    auto names = options.names;
    std::array<char, 256> name{};
    if (::gethostname(name.data(), name.size() - 1) == 0 && name[0] != '\0')
        names.push_back(host_name(name.data()).value_or("localhost"));
    return names;
}

GuardPolicy policy_of(const WebServerOptions& options) {
    return {.address = options.address.host,
            .names = names_of(options),
            .token = options.token,
            .allow_write = options.allow_write};
}

// One visitor gets at most half of the threads. Planning takes a processor: two plans at once.
RequestQueue::Limits queue_limits(const WebServerOptions& options) {
    const auto half = [](std::size_t all) { return RequestQueue::Share{all, (all + 1) / 2}; };
    RequestQueue::Limits limits{.waiting = options.waiting, .waiting_of_visitor = options.visitor_waiting};
    limits.executing[static_cast<std::size_t>(Work::quick)] = half(options.threads);
    limits.executing[static_cast<std::size_t>(Work::planning)] = half(2);
    limits.executing[static_cast<std::size_t>(Work::device)] = half(8);
    return limits;
}

std::size_t threads_of(const RequestQueue::Limits& limits) {
    std::size_t sum = 0;
    for (const auto& share : limits.executing) sum += share.all;
    return sum;
}

int status_of(BufferQuota::Verdict verdict) {
    switch (verdict) {
        case BufferQuota::Verdict::admitted: break;
        case BufferQuota::Verdict::visitor_full: return 429;
        case BufferQuota::Verdict::full: return 503;
    }
    return 0;
}

/// Counts the requests that are being executed.
class Executing {
public:
    void begin() {
        const std::lock_guard lock(mutex_);
        ++count_;
    }
    void end() {
        const std::lock_guard lock(mutex_);
        if (--count_ == 0) ended_.notify_all();
    }
    /// @returns whether there are none, at last
    [[nodiscard]] bool wait_for_end(std::chrono::milliseconds limit) {
        std::unique_lock lock(mutex_);
        return ended_.wait_for(lock, limit, [this] { return count_ == 0; });
    }

private:
    std::mutex mutex_;
    std::condition_variable ended_;
    int count_ = 0;
};

}  // namespace

// Reached from the server's thread, from the workers and from producers of events. It outlives the loop's
// last task, and poke() after stop() finds no loop any more.
struct WebServer::Impl {
    Impl(const WebServerOptions& with, std::vector<ApiRoute> routes, std::vector<StreamRoute> streams)
        : options(with),
          router(policy_of(with), with.proxies, with.language, std::move(routes), std::move(streams),
                 with.log),
          rates(with.burst, std::chrono::nanoseconds(std::chrono::seconds(1)) / with.requests_per_second),
          quota(with.visitor_buffered, with.buffered),
          queue(queue_limits(with)) {}

    /// A request that waits or is being executed. Its id is that of its connection, which has one at a time.
    struct Accepted {
        std::shared_ptr<HttpRequest> request;  // null: it is being executed
        std::stop_source stop;
        std::string opens_stream;  // its visitor, if it opens a stream
    };

    WebServerOptions options;
    HttpRouter router;
    Executing executing;
    std::unique_ptr<line::Loop> loop;
    std::unique_ptr<os::Worker> worker;
    // Of the server's thread.
    PeerRates rates;
    BufferQuota quota;
    RequestQueue queue;
    std::map<std::uint64_t, HttpConnection*> connections;
    std::map<std::uint64_t, Accepted> requests;
    std::uint64_t last_connection = 0;
    std::unique_ptr<line::TcpServer> server;
    std::thread thread;
    std::uint16_t port = 0;
    std::atomic<bool> poked = false;
    std::atomic<bool> stopping = false;
    std::mutex stop_mutex;  // poke() against stop()

    Result<void> begin() {
        TAKT_TRY(loop, line::Loop::create());
        worker =
            std::make_unique<os::Worker>(os::Worker::Options{.name = "takt-answers",
                                                             .threads = threads_of(queue_limits(options)),
                                                             .queue = threads_of(queue_limits(options))});
        line::TcpServerOptions serving;
        serving.max_connections = options.connections + kAnsweredWith503;
        serving.max_per_peer = options.visitor_connections;
        serving.shared_peers = options.proxies;
        serving.evict_after = kEvictAfter;
        serving.log = options.log;
        TAKT_TRY(server,
                 line::TcpServer::listen(
                     *loop, options.address,
                     [this](Instant t, const line::Peer& peer) { return accept(t, peer.address); }, serving));
        port = server->port();
        thread = std::thread([this] {
            os::name_thread("takt-web");
            loop->run();
        });
        return {};
    }

    std::unique_ptr<line::Session> accept(Instant t, std::string_view peer) {
        const auto id = ++last_connection;
        auto connection = std::make_unique<HttpConnection>(
            HttpConnection::Limits{}, peer, t,
            HttpConnection::Owner{
                .admit = [this](HttpRequest& request) { return admit(request); },
                .execute = [this, id](HttpRequest request) { return execute(id, std::move(request)); },
                .reserve = [this](std::string_view visitor,
                                  std::ptrdiff_t change) { return status_of(quota.change(visitor, change)); },
                .input_ended = [this, id] { stop_request(id); },
                .destroyed = [this, id] { forget(id); }});
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

    // What is refused counts as a request too.
    std::optional<HttpReply> admit(HttpRequest& request) {
        auto refusal = router.admit(request);
        if (!rates.admit(request.visitor, line::now()) || (request.is_stream && has_all_streams(request)))
            return HttpReply{.bytes = bare_reply(429), .close = true};
        return refusal;
    }

    [[nodiscard]] bool has_all_streams(const HttpRequest& request) const {
        const auto open = std::ranges::count_if(connections, [&](const auto& entry) {
            return entry.second->streams() && entry.second->visitor() == request.visitor;
        });
        const auto opening = std::ranges::count_if(
            requests, [&](const auto& entry) { return entry.second.opens_stream == request.visitor; });
        return static_cast<std::size_t>(open + opening) >= options.visitor_streams;
    }

    int execute(std::uint64_t id, HttpRequest request) {
        if (connections.size() <= options.connections) return accept_request(id, std::move(request));
        // Others cannot be closed here, in the middle of a call of this connection's engine.
        auto shared = std::make_shared<HttpRequest>(std::move(request));
        loop->post([this, id, shared] {
            evict();
            const bool admitted = connections.size() <= options.connections;
            if (const int status = admitted ? accept_request(id, std::move(*shared)) : 503; status != 0)
                answer(id, {.bytes = bare_reply(status), .close = true});
        });
        return 0;
    }

    // @returns 0, or the status where it may not wait
    int accept_request(std::uint64_t id, HttpRequest request) {
        if (!connections.contains(id)) return 0;  // its client has gone meanwhile
        switch (queue.push({id, request.work, request.visitor, request.superseded_by})) {
            case RequestQueue::Pushed::accepted: break;
            case RequestQueue::Pushed::visitor_full: return 429;
            case RequestQueue::Pushed::full: return 503;
        }
        Accepted accepted;
        if (request.is_stream) accepted.opens_stream = request.visitor;
        request.stop = accepted.stop.get_token();
        accepted.request = std::make_shared<HttpRequest>(std::move(request));
        requests.emplace(id, std::move(accepted));
        for (const auto older : queue.superseded()) stop_request(older);
        start_requests();
        return 0;
    }

    void start_requests() {
        while (const auto id = queue.next()) {
            executing.begin();
            const bool posted = worker->post([this, id = *id, request = std::move(requests.at(*id).request)] {
                auto reply = std::make_shared<HttpReply>(router.reply(std::move(*request)));
                loop->post([this, id, reply] { finish_request(id, std::move(*reply)); });
                executing.end();
            });
            TAKT_ASSERT(posted);  // there are as many threads as requests may be executed
        }
    }

    void finish_request(std::uint64_t id, HttpReply reply) {
        queue.remove(id);
        requests.erase(id);
        answer(id, std::move(reply));
        start_requests();
    }

    // It answers early, if its handler looks at the token.
    void stop_request(std::uint64_t id) {
        const auto found = requests.find(id);
        if (found == requests.end()) return;
        found->second.stop.request_stop();
        queue.cut_short(id);
    }

    // The connection is destroyed. A request that is being executed is kept until it ends.
    void forget(std::uint64_t id) {
        connections.erase(id);
        stop_request(id);
        if (const auto found = requests.find(id); found != requests.end() && found->second.request) {
            queue.remove(id);
            requests.erase(found);
        }
    }

    void answer(std::uint64_t id, HttpReply reply) {
        const auto found = connections.find(id);
        if (found == connections.end()) return;  // the browser has gone
        found->second->answer(std::move(reply));
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

    bool stop() {
        {
            const std::lock_guard lock(stop_mutex);
            if (stopping.exchange(true)) return executing.wait_for_end({});
        }
        if (loop) loop->stop();
        if (thread.joinable()) thread.join();
        for (auto& [id, request] : requests) request.stop.request_stop();
        server.reset();
        return executing.wait_for_end(kStopLimit);
    }

    ~Impl() {
        static_cast<void>(stop());
        worker.reset();  // its jobs post to the loop
    }
};

WebServer::WebServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
WebServer::~WebServer() = default;

Result<std::unique_ptr<WebServer>> WebServer::start(const WebServerOptions& options,
                                                    std::vector<ApiRoute> routes,
                                                    std::vector<StreamRoute> streams) {
    std::unique_ptr<WebServer> server(
        new WebServer(std::make_unique<Impl>(options, std::move(routes), std::move(streams))));
    TAKT_CHECK(server->impl_->begin());
    return server;
}

bool WebServer::stop() {
    return impl_->stop();
}

void WebServer::poke() {
    impl_->poke();
}

std::uint16_t WebServer::port() const {
    return impl_->port;
}

std::optional<std::string> parse_web_name(std::string_view text) {
    if (const auto address = parse_ip(text)) return lower_ascii(text);
    auto name = text.starts_with('[') ? std::nullopt : host_name(text);
    const bool has_port = text.find(':') != std::string_view::npos;
    if (!name || has_port || name->front() == '.' || name->back() == '.' || name->contains("..")) return {};
    return name;
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
