// Targets as URLs on the command line (docs/commands/README.md).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "takt/base/result.hpp"
#include "takt/model/project.hpp"
#include "takt/model/target_url.hpp"

namespace takt::line {

/// tcp://host[:502], tls://host[:802][?certs=FOLDER], rtu+tcp://host[:502], rtu:///dev/…, ascii:///dev/… with
/// ?baud=19200&parity=even&stop_bits=1&data_bits=8&rs485=auto behind a serial port (19200 8E1, ASCII 7E1).
/// A host is a name, an IPv4 address, or an IPv6 address in brackets.
struct Target {
    model::Transport transport = model::Transport::tcp;  ///< serial, tcp or tls
    wire::Framing framing = wire::Framing::tcp;
    std::string port;  ///< serial: the device file; else the host
    std::uint16_t tcp_port = 502;
    std::string certificates{model::kCertificateFolder};  ///< tls: the folder of model::files_in()
    wire::CharacterFormat format;  ///< of a serial port; baud 0 else: a byte stream has no character times
    model::Rs485 rs485 = model::Rs485::automatic;

    /// The target as a line of a project, without devices, named after its port or host.
    [[nodiscard]] model::Line as_line() const;

    friend bool operator==(const Target&, const Target&) = default;
};

/// Reads a target. Pure.
/// @returns syntax with the part that cannot be read as subject, and where the right form is known, behind
/// an arrow: "10.0.0.5:502 → tcp://10.0.0.5:502", "bauds → baud, parity, stop_bits, data_bits, rs485";
/// out_of_range with the part ("port", "baud", …), its value, least and greatest
[[nodiscard]] Result<Target> parse_target(std::string_view url);

/// Where a server listens.
struct ListenAddress {
    std::string host;  ///< numeric address; empty: all addresses, IPv6 and IPv4
    std::uint16_t port = 502;
    std::optional<std::string> certificates = std::nullopt;  ///< TLS with those of the folder
};

/// Reads "127.0.0.1:1502", "[::1]:1502", "*:502", ":502", all also behind "tcp://" or, for TLS with
/// port 802, "tls://" and with "?certs=FOLDER". A port of 0: any free one. Errors as parse_target().
[[nodiscard]] Result<ListenAddress> parse_listen(std::string_view text);

using model::host_and_port;

}  // namespace takt::line
