// The command line of takt-sim.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "world.hpp"

namespace takt::simtest {

struct Options {
    std::uint64_t first = 1;
    std::uint64_t last = 1;
    double minutes = 10;
    unsigned jobs = 1;
    std::string project;          ///< file; empty: a random one for each seed
    std::string faults = "seed";  ///< as given
    FaultChoice choice;
    std::string resume;  ///< file
    bool lenient = false;
    bool json = false;
    bool trace = false;
    bool print_project = false;
    bool help = false;

    [[nodiscard]] Duration length() const;
};

/// The error in the arguments, in English; nothing: `options` is set.
[[nodiscard]] std::optional<std::string> parse_options(std::span<char*> arguments, Options& options);

[[nodiscard]] std::string usage();

/// The arguments that run this seed again.
[[nodiscard]] std::string replay(const Options& options, std::uint64_t seed);

}  // namespace takt::simtest
