// A TCP server: an engine for each connection.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/base/log.hpp"
#include "takt/base/network.hpp"
#include "takt/base/result.hpp"
#include "takt/line/byte_stream.hpp"
#include "takt/line/loop.hpp"
#include "takt/line/target.hpp"
#include "takt/tls/context.hpp"

namespace takt::line {

/// Serves one connection. Made by the factory when the connection is accepted, destroyed when it is closed.
class Session {
public:
    virtual ~Session() = default;
    [[nodiscard]] virtual Engine& engine() = 0;
    /// Bytes that the engine can accept now; 0: the peer must wait. Called before every read.
    [[nodiscard]] virtual std::size_t wants_bytes() const { return std::numeric_limits<std::size_t>::max(); }
    /// Whether the connection is to be closed once the transmitted bytes are written: bad header, idle too
    /// long. Called after every call of the engine.
    [[nodiscard]] virtual bool finished() const { return false; }
    /// Whether the transmitted bytes are the last ones. The sending side is then closed; the peer may still
    /// send.
    [[nodiscard]] virtual bool output_ended() const { return false; }
    /// Whether every request received so far is answered.
    [[nodiscard]] virtual bool drained() const { return true; }
    /// The peer has closed its sending side. It may still read.
    virtual void on_input_end() {}
    /// When the last byte was received, or the connection was accepted.
    [[nodiscard]] virtual Instant last_received() const = 0;
    /// Called once, before the engine's on_link().
    /// @param poke  to be called after the engine was changed from outside; may destroy the session
    virtual void attach(std::function<void()> /*poke*/) {}  // NOLINT(performance-*): overriders keep it
};

/// The other end of an accepted connection.
struct Peer {
    std::string_view address;  ///< "10.0.0.5:49152", "[::1]:49152"
    std::string_view role;     ///< of its certificate (tls::role_of()); empty: none
};

/// @returns nullptr: the connection is refused (closed at once)
using SessionFactory = std::function<std::unique_ptr<Session>(Instant t, const Peer& peer)>;

struct TcpServerOptions {
    std::size_t max_connections = 256;  ///< one beyond is accepted and closed at once
    std::size_t max_per_peer = 0;       ///< from one address, likewise; 0: as many as there may be in all
    /// Addresses of many clients, such as proxies: max_per_peer does not count for them.
    std::vector<Network> shared_peers = {};
    /// A connection that has been idle for this long may be closed for a new one.
    Duration evict_after = std::chrono::seconds(10);
    /// A client that accepts no bytes of an answer for this long is disconnected. At most one answer waits;
    /// meanwhile nothing is read from the client.
    Duration write_limit = std::chrono::seconds(10);
    /// Connections are TLS with it; nullptr: plain TCP.
    std::shared_ptr<const tls::Context> tls = nullptr;
    Duration handshake_limit = std::chrono::seconds(5);  ///< of TLS, from accepting to its end
    Log log{};  ///< refused, failed and stalled connections are logged, each kind at most once a second
};

struct TcpServerCounters {
    std::uint64_t accepted = 0;
    std::uint64_t refused = 0;          ///< all refused connections
    std::uint64_t over_limit = 0;       ///< of these: beyond max_connections
    std::uint64_t over_peer_limit = 0;  ///< of these: beyond max_per_peer
    std::uint64_t by_factory = 0;       ///< of these: the factory returned nullptr
    std::uint64_t no_descriptors = 0;   ///< of these: no descriptors were left
    std::uint64_t no_tls = 0;           ///< of these: the handshake failed
    std::uint64_t evicted = 0;          ///< closed for new ones
    std::uint64_t write_stalls = 0;     ///< cut off after write_limit
    std::uint64_t bytes_read = 0;       ///< of closed connections
    std::uint64_t bytes_written = 0;    ///< of closed connections
};

/// Listens on one address and serves every connection with an engine of its own.
///
/// If the limit is reached, an idle connection is closed for a new one: of the address with the most
/// connections, the one that has been idle for the longest time. Beyond `max_per_peer` it is one of the same
/// address. If no connection has been idle for `evict_after`, the new one is refused.
///
/// A client that has closed its sending side gets the answers to what it asked before. When descriptors run
/// out, spare ones are used to refuse waiting clients, and accepting pauses for 0.1 s; established
/// connections continue. The loop must outlive the server. Destroying it closes all connections. The loop's
/// thread only.
class TcpServer {
public:
    /// @returns cannot_open (host:port, errno)
    [[nodiscard]] static Result<std::unique_ptr<TcpServer>> listen(Loop& loop, const ListenAddress& address,
                                                                   SessionFactory factory,
                                                                   const TcpServerOptions& options = {});
    ~TcpServer();
    TcpServer(const TcpServer&) = delete;
    TcpServer& operator=(const TcpServer&) = delete;

    /// The address it listens on; for port 0 with the port that the system chose.
    [[nodiscard]] const std::string& name() const;
    [[nodiscard]] std::uint16_t port() const;

    /// Must be called after engines were changed from outside.
    void poke();

    [[nodiscard]] std::size_t connections() const;
    [[nodiscard]] TcpServerCounters counters() const;

private:
    struct Impl;
    explicit TcpServer(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace takt::line
