// Reports of a serial port to its operator.
#pragma once

#include <string>
#include <vector>

#include "takt/endpoint/notice.hpp"
#include "takt/line/serial_port.hpp"

namespace takt::endpoint {

/// How soon the port hands on received bytes.
[[nodiscard]] std::vector<Notice> latency_notices(const std::string& port,
                                                  const line::SerialLatency& latency);

}  // namespace takt::endpoint
