// The URL of a line, as targets are named on the command line.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "takt/model/line.hpp"

namespace takt::model {

/// "host:502", "[::1]:502".
[[nodiscard]] std::string host_and_port(std::string_view host, std::uint16_t port);

/// "tcp://host:502", "rtu:///dev/ttyUSB0?baud=9600&parity=none&stop_bits=1", for ASCII with
/// "&data_bits=7", and with "&rs485=rts" where it is not automatic.
[[nodiscard]] std::string url_of(const Line& line);

/// The character settings of a serial line: "19200 8E1"; empty for a network line.
[[nodiscard]] std::string settings_text(const Line& line);

}  // namespace takt::model
