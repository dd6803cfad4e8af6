// A line of a project: its connection and its devices.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/model/device.hpp"
#include "takt/model/document.hpp"
#include "takt/model/tls_files.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::model {

enum class Transport : std::uint8_t { serial, tcp, tls, simulated };
/// A connection to a host, as opposed to a port of this computer.
[[nodiscard]] constexpr bool is_network(Transport transport) {
    return transport == Transport::tcp || transport == Transport::tls;
}
enum class Rs485 : std::uint8_t { automatic, kernel, rts, none };
enum class PollOrder : std::uint8_t { deadline, address };

/// Relayed requests on a line.
struct SharedLine {
    Duration response_timeout{};  ///< the longest of all servers that relay to the line
    bool broadcast = false;       ///< one of them relays to unit 0
};

/// When a line over TCP has a connection.
enum class ConnectionUse : std::uint8_t {
    keep,         ///< as long as the peer keeps it
    per_request,  ///< one for each request
    per_cycle,    ///< it is closed as soon as no request is due
    on_demand,    ///< it is closed when no request was due for `idle_close`
};

struct ConnectionRules {
    ConnectionUse use = ConnectionUse::keep;
    std::optional<Duration> idle_close;     ///< exactly with on_demand
    Duration pause_after{};                 ///< least time from connecting to the first request
    std::optional<std::uint16_t> per_host;  ///< connections of all lines to this host at a time

    friend bool operator==(const ConnectionRules&, const ConnectionRules&) = default;
};

struct Line {
    std::string name;
    SourceLocation location;
    Transport transport = Transport::serial;
    std::string port;  ///< serial: the device file; tcp, tls: host name or address
    std::uint16_t tcp_port = 502;
    TlsFiles tls;  ///< with Transport::tls
    wire::Framing framing = wire::Framing::rtu;
    wire::CharacterFormat format;  ///< of serial and simulated serial lines
    Rs485 rs485 = Rs485::automatic;
    PollOrder order = PollOrder::deadline;
    Duration request_gap{};
    Duration frame_gap{};
    /// Longest pause inside a response; after it the received bytes are taken as complete. Nothing: 30 ms, or
    /// t3.5 if that is longer (ASCII: 1 s; streams: 50 ms).
    std::optional<Duration> byte_timeout;
    ConnectionRules connection;         ///< TCP
    bool length_tolerance = false;      ///< Framing::tcp: the length in a header may be off by one
    std::optional<SharedLine> relayed;  ///< a server relays to it
    /// A relayed request goes ahead of polling that is due if the last one ended this long ago.
    Duration relay_interval = std::chrono::seconds(1);
    /// How many commands go ahead of polling that is due, of those without a limit of their own; the interval
    /// counts from the end of a command to the start of the next.
    RateLimit commands{.min_interval = std::chrono::milliseconds(250), .burst = 1};
    std::vector<Device> devices;  ///< may be empty where it is relayed to

    /// Nothing answers at unit 0, but over Modbus TCP.
    [[nodiscard]] bool is_broadcast(const Device& device) const {
        return framing != wire::Framing::tcp && device.address == kBroadcast;
    }
    /// RTU or ASCII characters on a real or simulated serial line, as opposed to a byte stream.
    [[nodiscard]] bool is_serial() const {
        return transport == Transport::serial ||
               (transport == Transport::simulated && framing != wire::Framing::tcp);
    }
};

std::string_view name(Transport transport);

}  // namespace takt::model
