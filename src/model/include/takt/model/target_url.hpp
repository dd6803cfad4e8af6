// The URL of a line, as targets are named on the command line.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "takt/model/line.hpp"

namespace takt::model {

/// "host:502", "[::1]:502".
[[nodiscard]] std::string host_and_port(std::string_view host, std::uint16_t port);

/// "tcp", "tls", "rtu+tcp", "rtu", "ascii"
[[nodiscard]] std::string_view scheme_of(const Line& line);

/// "tcp://host:502", "rtu:///dev/ttyUSB0?baud=9600&parity=none&stop_bits=1", for ASCII with
/// "&data_bits=7", and with "&rs485=rts" where it is not automatic.
[[nodiscard]] std::string url_of(const Line& line);

/// The character settings of a serial line: "19200 8E1"; empty for a network line.
[[nodiscard]] std::string settings_text(const Line& line);

/// The keys of a serial port, in a URL and in a project.
inline constexpr std::array<std::string_view, 5> kPortKeys{"baud", "parity", "stop_bits", "data_bits",
                                                           "rs485"};

struct PortSettings {
    std::string port;
    std::vector<std::pair<std::string_view, std::string>> settings;

    /// "baud=9600&parity=even" with "=" and "&".
    [[nodiscard]] std::string joined(std::string_view equals, std::string_view separator) const;
};

/// A serial port with its settings in the notation of other tools: "/dev/ttyUSB0,9600,8E1",
/// "/dev/ttyUSB0:9600", "/dev/ttyUSB0?baud=9600", "rtu:///dev/ttyUSB0", "ttyUSB0", "COM3". Nothing if there
/// is only a device file, or a part that has no known meaning.
[[nodiscard]] std::optional<PortSettings> port_settings(std::string_view text);

/// The number of "COM3"; 0: it is no such name.
[[nodiscard]] unsigned com_number(std::string_view text);

struct NetworkAddress {
    std::string_view host;
    std::string_view tcp_port;  ///< empty: not given
    bool rtu = false;           ///< RTU frames over TCP
};

/// An address of a network where a serial port belongs: "10.0.0.1", "plc:502", "tcp://plc",
/// "rtu://10.0.0.1:4001". Nothing for a name alone.
[[nodiscard]] std::optional<NetworkAddress> network_address(std::string_view text);

}  // namespace takt::model
