// takt-sim: the whole bus in simulation, for many seeds.
#include <cstdio>
#include <iostream>

#include "report.hpp"
#include "seeds/runner.hpp"
#include "topology.hpp"

namespace takt::simtest {
namespace {

/// Runs one seed. A violation is printed to stderr at once.
seeds::Record run_seed(const Options& options, const model::Project* given, std::uint64_t seed) {
    Run settings{.seed = seed,
                 .length = options.length(),
                 .faults = options.choice,
                 .merciless = !options.lenient,
                 .trace = options.trace};
    Result result{.seed = seed};
    if (given) {
        result = run(*given, settings);
    } else if (const Topology topology = make_topology(seed); topology.error.empty()) {
        result = run(topology.project, settings);
    } else {
        result.violations.push_back({"reachable", {}, 0, "a legal project", topology.error});
    }
    if (!result.violations.empty()) std::fputs(violation_text(result, options).c_str(), stderr);
    return record_of(result);
}

int print_project(std::uint64_t seed) {
    const Topology topology = make_topology(seed);
    std::cout << topology.text;
    if (!topology.error.empty()) std::cerr << "takt-sim: " << topology.error << "\n";
    return topology.error.empty() ? 0 : 2;
}

int run_program(std::span<char*> arguments) {
    Options options;
    if (const auto wrong = parse_options(arguments, options)) {
        std::cerr << "takt-sim: " << *wrong << "\n";
        return 2;
    }
    if (options.help) {
        std::cout << usage();
        return 0;
    }
    if (options.print_project) return print_project(options.first);
    ReadProject project;
    if (!options.project.empty()) project = read_file(options.project);
    if (!project.error.empty()) {
        std::cerr << "takt-sim: " << options.project << ": " << project.error << "\n";
        return 2;
    }
    const model::Project* const given = options.project.empty() ? nullptr : &project.project;
    return seeds::run_seeds(
        options, {.name = "takt-sim",
                  .run = [&](std::uint64_t seed) { return run_seed(options, given, seed); },
                  .replay = [&](std::uint64_t seed) { return replay(options, seed); },
                  .missing_kinds = [&](const seeds::Counts& total) { return missing_kinds(total, options); },
                  .shown = "frames",
                  .all_kinds = given == nullptr && options.faults == "seed"});
}

}  // namespace
}  // namespace takt::simtest

int main(int argc, char** argv) {
    return takt::simtest::run_program(std::span(argv, static_cast<std::size_t>(argc)).subspan(1));
}
