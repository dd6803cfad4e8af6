// A Modbus TCP slave on the Ethernet of a microcontroller, over lwIP without an operating system.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "lwipopts.h"
#include "takt/base/engine.hpp"
#include "takt/serve/tcp_connection.hpp"

struct tcp_pcb;
struct pbuf;

namespace takt::firmware {

struct TcpDeviceConfig {
    std::array<std::uint8_t, 4> address{};  ///< IPv4
    std::array<std::uint8_t, 4> mask{255, 255, 255, 0};
    std::array<std::uint8_t, 4> gateway{};
    std::uint16_t port = 502;
    serve::TcpConfig connection;
    /// A peer that is silent for so long is probed; without a response to `keep_alive_probes` of them, the
    /// connection ends.
    Duration keep_alive = std::chrono::seconds(10);
    Duration keep_alive_interval = std::chrono::seconds(2);
    std::uint32_t keep_alive_probes = 3;
};

/// Of a device, since its start.
struct TcpDeviceCounters {
    std::uint16_t accepted = 0;
    std::uint16_t refused = 0;  ///< because kConnections were open
    std::uint16_t closed = 0;
    std::uint16_t unsent_frames = 0;  ///< the controller had no space
};

/// Memory of lwIP that is in use, and the most that was.
struct TcpDeviceMemory {
    std::uint16_t connections = 0;  ///< in any state, those being opened or closed included
    std::uint16_t pool = 0;         ///< buffers of received frames
    std::uint16_t heap = 0;         ///< bytes
    std::uint16_t most_heap = 0;
};

/// Serves kConnections connections; a further one is reset. Each has its buffers, so that no peer takes those
/// of another one: kWindow bytes that are not processed yet, which is the receive window that lwIP announces,
/// and kOutput bytes of responses. A peer that does not read is not read either, and the idle deadline ends
/// it. lwIP is only called from the main loop, its callbacks only note what came.
///
/// Each state ends in bounded time: a handshake after 20 s, a dead peer by keep-alive, a closed connection
/// whose peer does not acknowledge after kClosing.
///
/// No heap but that of lwIP, which has a fixed size (lwip/lwipopts.h). One per program; the main loop only.
class TcpDevice {
public:
    static constexpr std::size_t kConnections = TAKT_TCP_CONNECTIONS;
    static constexpr std::size_t kWindow = TAKT_TCP_WINDOW;
    static constexpr std::size_t kOutput = 1024;
    static constexpr Duration kClosing = std::chrono::seconds(5);

    /// @param responder  outlives it; its answers are responses or silence, never pending
    TcpDevice(const TcpDeviceConfig& config, serve::Responder& responder);

    /// To be called after board::open(), which starts the clock and the timer.
    /// @returns false: the Ethernet controller does not answer
    [[nodiscard]] bool start();

    /// Processes the frames that came and the timers that expired, and sends. Sets the board's timer for the
    /// next one. Then the main loop sleeps if has_work() is false with interrupts masked.
    /// @returns false: nothing more can be done at once
    bool work();
    [[nodiscard]] bool has_work() const;

    [[nodiscard]] const TcpDeviceCounters& counters() const { return counters_; }
    [[nodiscard]] TcpDeviceMemory memory() const;

private:
    using Engine = serve::BufferedTcpConnection<wire::kMaxTcpFrame, kOutput>;

    struct Connection {
        TcpDevice* device = nullptr;
        tcp_pcb* pcb = nullptr;  // null: free
        std::optional<Engine> engine;
        bool peer_closed = false;
        std::size_t received_size = 0;
        Bytes unsent;  // of the engine; before they are written, the engine is not called
        std::array<std::uint8_t, kWindow> received;
    };

    // Callbacks of lwIP
    static std::int8_t on_accept(void* device, tcp_pcb* pcb, std::int8_t error);
    static std::int8_t on_received(void* connection, tcp_pcb* pcb, pbuf* bytes, std::int8_t error);
    static void on_error(void* connection, std::int8_t error);

    void receive_frames();
    void serve(Instant t, Connection& connection);
    bool write(Instant t, Connection& connection);
    void feed(Instant t, Connection& connection);
    [[nodiscard]] bool overdue(Instant t, const Connection& connection) const;
    void close(Connection& connection, bool at_once);
    void forget(Connection& connection);
    void set_timer(Instant t);

    const TcpDeviceConfig config_;
    serve::Responder& responder_;
    TcpDeviceCounters counters_;
    std::array<Connection, kConnections> connections_;
    std::uint32_t timer_since_ = 0;  // by board::clock()
    std::uint32_t timer_ = 0;        // microseconds
};

}  // namespace takt::firmware
