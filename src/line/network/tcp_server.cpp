// Accepts connections in batches of kAcceptsAtOnce, so that established connections are served in between. A
// connection is refused by closing it at once: beyond the limits, by the factory, or for lack of descriptors.
// Before that an idle connection is evicted if there is one, so that unused connections keep no client out.
// Log lines of one kind are limited to one per kLogPause; the counters are exact.
#include "takt/line/tcp_server.hpp"

#include <fcntl.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <list>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "loop/pump.hpp"
#include "network/handshake.hpp"
#include "takt/line/socket.hpp"
#include "takt/os/descriptor.hpp"

namespace takt::line {

struct ServedConnection {
    std::unique_ptr<ByteStream> stream;
    std::string peer;
    std::size_t& from_peer;  // connections of its address
    std::unique_ptr<Session> session;
    std::unique_ptr<Pump> pump = nullptr;
};

namespace {

constexpr Duration kLogPause = std::chrono::seconds(1);
constexpr Duration kAcceptPause = std::chrono::milliseconds(100);
constexpr int kAcceptsAtOnce = 16;  // limits the delay of established connections

std::array<os::Descriptor, 2> open_spare() {
    const auto open = [] { return os::Descriptor(::open("/dev/null", O_RDONLY | O_CLOEXEC)); };
    return {open(), open()};
}

Result<os::Descriptor> open_listener(const SocketAddress& address, bool all_families,
                                     const std::string& name) {
    TAKT_TRY(os::Descriptor fd, open_socket(address.family()));
    const int on = 1;
    ::setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (address.family() == AF_INET6) {
        const int only_ipv6 = all_families ? 0 : 1;
        ::setsockopt(fd.get(), IPPROTO_IPV6, IPV6_V6ONLY, &only_ipv6, sizeof only_ipv6);
    }
    if (::bind(fd.get(), address.get(), address.length) != 0 || ::listen(fd.get(), SOMAXCONN) != 0)
        return fail(Code::cannot_open, name, errno);
    return fd;
}

// The wildcard address. One IPv6 socket serves IPv4 as well; without IPv6 the socket is IPv4.
Result<os::Descriptor> open_listener(const ListenAddress& where) {
    const bool all = where.host.empty();
    TAKT_TRY(const auto addresses, resolve(all ? "::" : where.host, where.port, true));
    const std::string name = host_and_port(all ? "*" : where.host, where.port);
    auto fd = open_listener(addresses.front(), all, name);
    if (fd || !all || (fd.error().numbers[0] != EAFNOSUPPORT && fd.error().numbers[0] != EADDRNOTAVAIL))
        return fd;
    TAKT_TRY(const auto ipv4, resolve("0.0.0.0", where.port, true));
    return open_listener(ipv4.front(), false, name);
}

/// "10.0.0.5:49152" without the port.
std::string host_of(const std::string& peer) {
    return peer.substr(0, peer.rfind(':'));
}

}  // namespace

struct TcpServer::Impl {
    Impl(Loop& on_loop, os::Descriptor fd, SessionFactory sessions, const TcpServerOptions& with)
        : loop(on_loop),
          listener(std::move(fd)),
          factory(std::move(sessions)),
          options(with),
          watch(on_loop, listener.get(), [this] { accept_some(); }),
          resume(on_loop, [this](Instant) { watch.want_read(); }) {
        if (options.tls) handshakes.emplace(loop, options.tls, options.handshake_limit);
    }

    Loop& loop;
    os::Descriptor listener;
    std::array<os::Descriptor, 2> spare = open_spare();
    SessionFactory factory;
    TcpServerOptions options;
    std::string name;
    std::uint16_t port = 0;
    TcpServerCounters counters;
    std::unordered_map<std::string, std::size_t> peers;  // connections by address
    std::list<ServedConnection> connections;
    Instant next_refusal_log = Instant::min();
    Instant next_stall_log = Instant::min();
    Instant next_tls_log = Instant::min();
    std::optional<Handshakes> handshakes;
    Watch watch;
    Timer resume;

    void accept_some();
    void serve(os::Descriptor fd, const SocketAddress& address);
    void establish(std::unique_ptr<ByteStream> stream, const std::string& peer, std::string_view role);
    void leave(const std::string& peer);
    void note_no_tls(const Error& why);
    /// Connections that an address may have.
    [[nodiscard]] std::size_t most_of(std::string_view peer) const;
    [[nodiscard]] bool evict(const std::size_t* only_peer);
    void closed(std::list<ServedConnection>::iterator connection, const std::optional<Error>& why);
    void refuse_without_descriptors();
    void warn(std::string_view code, std::string_view peer, std::uint64_t count) const;
    void refuse(std::string_view peer, std::uint64_t& because);
};

void TcpServer::Impl::accept_some() {
    for (int accepted = 0; accepted < kAcceptsAtOnce; ++accepted) {
        SocketAddress address;
        address.length = sizeof address.storage;
        os::Descriptor fd(
            ::accept4(listener.get(), address.get(), &address.length, SOCK_NONBLOCK | SOCK_CLOEXEC));
        if (fd) {
            serve(std::move(fd), address);
        } else if (errno == EAGAIN) {
            break;
        } else if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM) {
            if (evict(nullptr)) continue;
            refuse_without_descriptors();
            resume.set(now() + kAcceptPause);
            return;
        }  // any other error concerns only this client (accept(2)): continue with the next
    }
    watch.want_read();
}

// Without free descriptors accept() fails and clients would wait in the backlog. The spare descriptors are
// closed to accept and close these clients, so that they learn at once that they are refused. The refusals
// are logged before the spare ones are reopened, because the log may need descriptors too.
void TcpServer::Impl::refuse_without_descriptors() {
    spare = {};
    for (int refused = 0; refused < kAcceptsAtOnce; ++refused) {
        os::Descriptor client(::accept4(listener.get(), nullptr, nullptr, SOCK_CLOEXEC));
        if (!client) break;
        client.reset();
        refuse({}, counters.no_descriptors);
    }
    spare = open_spare();
}

void TcpServer::Impl::warn(std::string_view code, std::string_view peer, std::uint64_t count) const {
    const std::string times = std::to_string(count);
    options.log.message(LogLevel::warning, code,
                        std::vector<LogArgument>{{.name = "peer", .text = peer.empty() ? "?" : peer},
                                                 {.name = "count", .text = times}});
}

void TcpServer::Impl::refuse(std::string_view peer, std::uint64_t& because) {
    ++counters.refused;
    ++because;
    const Instant t = now();
    if (t < next_refusal_log) return;
    next_refusal_log = after(t, kLogPause);
    warn("log.client_refused", peer, counters.refused);
}

// Closes an idle connection: the one idle for the longest time of the address that holds most.
// @param only_peer  the count of an address (ServedConnection::from_peer): one of this address; nullptr: of
// any
bool TcpServer::Impl::evict(const std::size_t* only_peer) {
    const Instant t = now();
    auto found = connections.end();
    const auto rank = [](const ServedConnection& connection) {
        return std::pair(connection.from_peer,
                         -connection.session->last_received().time_since_epoch().count());
    };
    for (auto connection = connections.begin(); connection != connections.end(); ++connection) {
        if (only_peer && &connection->from_peer != only_peer) continue;
        const Session& session = *connection->session;
        if (!session.drained() || t - session.last_received() < options.evict_after) continue;
        if (found == connections.end() || rank(*connection) > rank(*found)) found = connection;
    }
    if (found == connections.end()) return false;
    ++counters.evicted;
    found->pump->stop();
    return true;
}

std::size_t TcpServer::Impl::most_of(std::string_view peer) const {
    const auto address = parse_peer(peer);
    const auto holds = [&](const Network& network) { return address && network.contains(*address); };
    const bool limited = options.max_per_peer > 0 && std::ranges::none_of(options.shared_peers, holds);
    return limited ? options.max_per_peer : std::numeric_limits<std::size_t>::max();
}

void TcpServer::Impl::serve(os::Descriptor fd, const SocketAddress& address) {
    std::string peer = address.text();
    const auto known = peers.find(host_of(peer));
    if (known != peers.end() && known->second >= most_of(peer) && !evict(&known->second))
        return refuse(peer, counters.over_peer_limit);
    if (connections.size() >= options.max_connections && !evict(nullptr))
        return refuse(peer, counters.over_limit);
    set_connection_options(fd.get());
    if (!handshakes) {
        auto stream = std::make_unique<SocketStream>(std::move(fd), peer);
        return establish(std::move(stream), peer, {});
    }
    ++peers[host_of(peer)];
    handshakes->begin(std::move(fd), peer,
                      [this, peer](Result<std::unique_ptr<ByteStream>> stream, const std::string& role) {
                          leave(peer);
                          if (!stream) return note_no_tls(stream.error());
                          if (connections.size() >= options.max_connections && !evict(nullptr))
                              return refuse(peer, counters.over_limit);
                          establish(*std::move(stream), peer, role);
                      });
}

void TcpServer::Impl::leave(const std::string& peer) {
    const auto from = peers.find(host_of(peer));
    if (--from->second == 0) peers.erase(from);
}

void TcpServer::Impl::note_no_tls(const Error& why) {
    ++counters.refused;
    ++counters.no_tls;
    const Instant t = now();
    if (t < next_tls_log) return;
    next_tls_log = after(t, kLogPause);
    const std::string times = std::to_string(counters.no_tls);
    options.log.message(
        LogLevel::warning, "log.client_tls",
        std::vector<LogArgument>{{.name = "reason", .error = &why}, {.name = "count", .text = times}});
}

void TcpServer::Impl::establish(std::unique_ptr<ByteStream> stream, const std::string& peer,
                                std::string_view role) {
    auto session = factory(now(), {.address = peer, .role = role});
    if (!session) return refuse(peer, counters.by_factory);
    ++counters.accepted;
    std::size_t& of_peer = peers[host_of(peer)];
    ++of_peer;
    connections.push_front(
        {.stream = std::move(stream), .peer = peer, .from_peer = of_peer, .session = std::move(session)});
    const auto connection = connections.begin();
    PumpOptions pumping;
    pumping.pause_reading = true;
    pumping.write_limit = options.write_limit;
    pumping.wants_bytes = [served = connection->session.get()] { return served->wants_bytes(); };
    pumping.written_out = [connection] {
        if (connection->session->output_ended()) ::shutdown(connection->stream->fd(), SHUT_WR);
    };
    pumping.finished = [served = connection->session.get()] { return served->finished(); };
    pumping.drained = [served = connection->session.get()] { return served->drained(); };
    pumping.input_ended = [served = connection->session.get()] { served->on_input_end(); };
    connection->pump = std::make_unique<Pump>(
        loop, *connection->stream, connection->session->engine(), std::move(pumping),
        [this, connection](Instant, const std::optional<Error>& why) { closed(connection, why); });
    connection->session->attach([pump = connection->pump.get()] { pump->poke(); });
    connection->pump->start();
}

void TcpServer::Impl::closed(std::list<ServedConnection>::iterator connection,
                             const std::optional<Error>& why) {
    if (why && why->code == Code::timed_out) {
        ++counters.write_stalls;
        const Instant t = now();
        if (t >= next_stall_log) {
            next_stall_log = after(t, kLogPause);
            warn("log.client_stalled", connection->peer, counters.write_stalls);
        }
    }
    counters.bytes_read += connection->pump->counters().bytes_read;
    counters.bytes_written += connection->pump->counters().bytes_written;
    leave(connection->peer);
    connections.erase(connection);
}

TcpServer::TcpServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TcpServer::~TcpServer() = default;

Result<std::unique_ptr<TcpServer>> TcpServer::listen(Loop& loop, const ListenAddress& address,
                                                     SessionFactory factory,
                                                     const TcpServerOptions& options) {
    TAKT_TRY(os::Descriptor fd, open_listener(address));
    SocketAddress bound;
    bound.length = sizeof bound.storage;
    ::getsockname(fd.get(), bound.get(), &bound.length);
    auto impl = std::make_unique<Impl>(loop, std::move(fd), std::move(factory), options);
    impl->port = bound.port();
    impl->name = host_and_port(address.host.empty() ? "*" : address.host, impl->port);
    impl->watch.want_read();
    return std::unique_ptr<TcpServer>(new TcpServer(std::move(impl)));
}

const std::string& TcpServer::name() const {
    return impl_->name;
}
std::uint16_t TcpServer::port() const {
    return impl_->port;
}
std::size_t TcpServer::connections() const {
    return impl_->connections.size();
}
TcpServerCounters TcpServer::counters() const {
    return impl_->counters;
}

void TcpServer::poke() {
    // poke() may end and erase the connection.
    for (auto connection = impl_->connections.begin(); connection != impl_->connections.end();) {
        const auto poked = connection++;
        poked->pump->poke();
    }
}

}  // namespace takt::line
