// takt probe (docs/commands).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "commands/client_options.hpp"
#include "commands/common_options.hpp"
#include "exit_code.hpp"
#include "takt/wire/function.hpp"

namespace takt::app {

struct ProbeOptions : ClientOptions {
    std::vector<wire::Area> areas;  ///< empty: all four
    std::uint16_t first = 0;
    std::uint16_t last = 65535;
    std::optional<std::uint16_t> step;  ///< nothing: discover::step_within() of `max_requests`
    std::size_t max_requests = 4096;    ///< of each area
    bool yaml = false;
};

ExitCode probe(const CommonOptions& common, const ProbeOptions& options);

}  // namespace takt::app
