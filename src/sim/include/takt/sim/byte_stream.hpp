// A connection: bytes in order, each way for itself.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "takt/serve/tcp_connection.hpp"
#include "takt/sim/wire.hpp"

namespace takt::sim {

/// Joins a client's engine (sender 0 in the measured view) and a server's connection (sender 1) as a TCP
/// connection does. What one end gives to be sent arrives as a whole at the other `delay` plus `per_byte` for
/// each of its bytes later, and not before what was sent earlier. The server's wants_bytes() is obeyed; when
/// it asks for the connection's end, both are told that the link is down, and it stays down.
class ByteStream final : public Wire {
public:
    struct Options {
        Duration delay{};
        Duration per_byte = std::chrono::nanoseconds(10);
    };

    /// @param client, server  outlive the stream
    ByteStream(Engine& client, serve::TcpConnection& server, const Options& options);

    void set_link(Instant t, bool up) override;
    void run_until(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override;
    void set_observer(WireObserver* observer) override { observer_ = observer; }

private:
    struct Chunk {
        Instant start;
        Instant arrives;
        std::vector<std::uint8_t> bytes;
        std::size_t taken = 0;
    };
    using Queue = std::deque<Chunk>;

    void step(Instant t);
    void to_client(Instant t);
    void to_server(Instant t);
    void arrived(std::size_t sender, Queue& queue);
    void collect(Engine& engine, Queue& queue, Instant t);
    void collect_all(Instant t);

    Engine& client_;
    serve::TcpConnection& server_;
    Options options_;
    WireObserver* observer_ = nullptr;
    Queue to_server_;
    Queue to_client_;
    bool up_ = false;
    Instant now_;
};

}  // namespace takt::sim
