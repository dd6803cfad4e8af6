// The command line of takt-sim.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "seeds/options.hpp"
#include "world.hpp"

namespace takt::simtest {

struct Options : seeds::Options {
    std::string project;          ///< file; empty: a random one for each seed
    std::string faults = "seed";  ///< as given
    FaultChoice choice;
    bool lenient = false;
    bool print_project = false;
};

/// The error in the arguments, in English; nothing: `options` is set.
[[nodiscard]] std::optional<std::string> parse_options(std::span<char*> arguments, Options& options);

[[nodiscard]] std::string usage();

/// The command that runs this seed again.
[[nodiscard]] std::string replay(const Options& options, std::uint64_t seed);

}  // namespace takt::simtest
