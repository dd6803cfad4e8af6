// A connection in virtual time: ordered bytes in both directions.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "takt/serve/tcp_connection.hpp"
#include "takt/sim/disturber.hpp"
#include "takt/sim/wire.hpp"

namespace takt::sim {

/// How a server ends a connection.
enum class Ending : std::uint8_t {
    fin,         ///< what it has sent arrives; it executes no further request
    reset,       ///< what it has sent and the client has not received is lost, too
    half_close,  ///< what it has sent arrives; it executes further requests until the client closes
};

/// Joins a client's engine (sender 0 in the measured view) and a server's connection (sender 1) as TCP does.
/// The bytes of one transmit() arrive together: after `delay`, plus `per_byte` for each byte, and not before
/// earlier ones. The server's wants_bytes() is obeyed. When one end closes the connection, the client gets
/// on_close() and the server on_link(down), and the link stays down.
class ByteStream final : public Wire {
public:
    struct Options {
        Duration delay{};
        Duration per_byte = std::chrono::nanoseconds(10);
        /// Returns true if the client wants the connection closed. Called after every event.
        std::function<bool()> must_reconnect;
    };

    /// @param client, server  outlive the stream
    ByteStream(Engine& client, serve::TcpConnection& server, const Options& options);

    /// Suspends the client's computer until `until`. It then receives the bytes that arrived meanwhile.
    /// @param late_tick  its timers run before those bytes are delivered, not after
    void stall(Instant until, bool late_tick);
    /// From now on nothing arrives until the next link-up.
    void swallow() { swallows_ = true; }
    /// The server ends the connection. The client notices it behind the bytes that still arrive.
    void end(Instant t, Ending how);
    /// The connection is closed for both at this instant.
    void close(Instant t);
    [[nodiscard]] bool up() const { return up_; }
    /// The server can end it.
    [[nodiscard]] bool open() const { return up_ && !ended_ && !swallows_; }
    /// Engine::opens_at() of the client.
    [[nodiscard]] std::optional<Instant> client_opens_at() const { return client_.opens_at(); }
    [[nodiscard]] bool stalled() const { return stalled_until_.has_value(); }

    void set_link(Instant t, bool up) override;
    void run_until(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override;
    void set_disturber(Disturber* disturber) override { disturber_ = disturber; }
    void set_observer(WireObserver* observer) override { observer_ = observer; }

private:
    using Bytestring = std::vector<std::uint8_t>;
    struct Chunk {
        Instant start;
        Instant arrives;
        Bytestring bytes;
        std::size_t taken = 0;
        std::optional<Bytestring> sent = std::nullopt;  // where that is something else
        bool ends = false;                              // the connection, instead of bytes
    };
    using Queue = std::deque<Chunk>;

    void begin_anew(Instant t, bool up);
    void step(Instant t);
    void to_client(Instant t);
    void to_server(Instant t);
    void arrived(Instant t, std::size_t sender, Queue& queue);
    void lost(Instant t, std::size_t sender, Bytes bytes);
    void collect(Engine& engine, std::size_t sender, Instant t);
    void collect_all(Instant t);
    void send(std::size_t sender, Instant t, Bytes bytes);
    void send_pieces(std::size_t sender, Instant t, Bytes bytes);
    void push(std::size_t sender, Instant t, Duration delay, Bytestring bytes,
              std::optional<Bytestring> sent);
    void send_deferred(Instant t);
    void wake_client(Instant t);
    void close_if_wanted(Instant t);
    [[nodiscard]] Queue& queue_of(std::size_t sender) { return sender == 0 ? to_server_ : to_client_; }

    Engine& client_;
    serve::TcpConnection& server_;
    Options options_;
    WireObserver* observer_ = nullptr;
    Disturber* disturber_ = nullptr;
    Queue to_server_;
    Queue to_client_;
    struct Deferred {
        Instant when;
        std::size_t sender = 0;
        Bytestring bytes;
        std::optional<Bytestring> sent;
    };
    std::vector<Deferred> deferred_;  // sent only then
    std::vector<Piece> pieces_;
    std::optional<Instant> stalled_until_;
    bool late_tick_ = false;
    bool swallows_ = false;
    std::optional<Ending> ended_;  // by the server; the client has not noticed it
    bool up_ = false;
    Instant now_;
};

}  // namespace takt::sim
