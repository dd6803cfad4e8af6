// The command line of takt-gateway-sim.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "seeds/options.hpp"

namespace takt::gatewaysim {

struct Options : seeds::Options {
    Options() { minutes = 3; }
    bool print_project = false;
};

/// The error in the arguments, in English; nothing: `options` is set.
[[nodiscard]] std::optional<std::string> parse_options(std::span<char*> arguments, Options& options);

[[nodiscard]] std::string usage();

}  // namespace takt::gatewaysim
