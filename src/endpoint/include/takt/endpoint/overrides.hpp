// Settings of the command line that replace those of a project.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/model/server.hpp"
#include "takt/sim/fill.hpp"

namespace takt::endpoint {

/// Limits of each address that is listened on; those that are given count instead of the project's.
struct LimitOverrides {
    std::optional<std::uint32_t> max_connections;
    std::optional<std::uint32_t> max_per_peer;
    std::optional<Duration> byte_timeout;   ///< serial
    std::optional<Duration> frame_timeout;  ///< TCP and serial
    std::optional<Duration> idle_timeout;
    std::optional<Duration> write_timeout;

    [[nodiscard]] model::ListenLimits instead_of(const model::ListenLimits& limits) const;
};

struct Overrides {
    std::string listen;  ///< host:port; of device_endpoints() and blank_endpoint() only
    std::string port;    ///< serial port or serial target; likewise
    bool strict = false;
    LimitOverrides limits;
    std::optional<std::vector<model::AccessRule>> access;  ///< of all endpoints
    std::string audit;                                     ///< file, of all endpoints; empty: the project's
    sim::Fill fill = sim::Fill::zero;                      ///< of the units of servers
};

}  // namespace takt::endpoint
