#include "takt/endpoint/notice.hpp"

#include <system_error>

namespace takt::endpoint {

Notice low_latency_notice(const std::string& port, int error) {
    if (error == 0) return {Notice::Severity::status, "line.low_latency.done", {{"port", port}}, {}};
    return {Notice::Severity::status,
            "line.low_latency.failed",
            {{"port", port}, {"why", std::system_category().message(error)}},
            {}};
}

}  // namespace takt::endpoint
