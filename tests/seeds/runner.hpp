// Runs many seeds in parallel processes.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "options.hpp"
#include "record.hpp"

namespace takt::seeds {

/// A simulation.
struct Program {
    std::string name;
    /// Runs a seed in a process of its own. Prints a violation to stderr.
    std::function<Record(std::uint64_t seed)> run;
    /// The command that runs a seed again. That of seed 0 names the whole run.
    std::function<std::string(std::uint64_t seed)> replay;
    /// Kinds that a run of many seeds must have seen and has not.
    std::function<std::vector<std::string>(const Counts& total)> missing_kinds;
    std::string shown;               ///< the count that the text shows of each seed
    std::uint64_t many_seeds = 150;  ///< so many must see every kind
    bool all_kinds = true;           ///< false: the arguments leave out some
};

/// Each job is a process of its own, so that the memory of a run can be measured and a failed assertion shows
/// its seed. @returns 0 all invariants hold; 1 one does not, or a kind was never seen; 2 bad usage
[[nodiscard]] int run_seeds(const Options& options, const Program& program);

}  // namespace takt::seeds
