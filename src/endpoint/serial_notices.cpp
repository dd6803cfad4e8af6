#include "takt/endpoint/serial_notices.hpp"

#include <system_error>

namespace takt::endpoint {

std::vector<Notice> latency_notices(const std::string& port, const line::SerialLatency& latency) {
    std::vector<Notice> notices;
    if (latency.error == 0)
        notices.push_back({Notice::Severity::status, "line.low_latency.done", {{"port", port}}, {}});
    else
        notices.push_back({Notice::Severity::status,
                           "line.low_latency.failed",
                           {{"port", port}, {"why", std::system_category().message(latency.error)}},
                           {}});
    if (latency.receive_trigger > 1)
        notices.push_back({Notice::Severity::warning,
                           "line.receive_trigger",
                           {{"port", port}, {"count", std::to_string(latency.receive_trigger)}},
                           {}});
    return notices;
}

}  // namespace takt::endpoint
