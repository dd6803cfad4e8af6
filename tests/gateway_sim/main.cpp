// takt-gateway-sim: the gateway in simulation, for many seeds.
#include <algorithm>
#include <array>
#include <cstdio>
#include <iostream>
#include <string_view>

#include "options.hpp"
#include "scenario.hpp"
#include "seeds/runner.hpp"
#include "world.hpp"

namespace takt::gatewaysim {
namespace {

/// What many seeds must have seen.
constexpr std::array<std::string_view, 30> kKinds{"killed",
                                                  "power_cut",
                                                  "orderly_stop",
                                                  "crashed_at_operation",
                                                  "clock_jump",
                                                  "disk_failed",
                                                  "disk_full",
                                                  "disk_slow",
                                                  "decayed",
                                                  "sampler_stalls",
                                                  "output_stalls",
                                                  "broker_away",
                                                  "broker_forgets",
                                                  "half_open",
                                                  "cut",
                                                  "cut_at_message",
                                                  "cut_early",
                                                  "taken_over",
                                                  "connect_refused",
                                                  "connect_unanswered",
                                                  "message_refused",
                                                  "puback_late",
                                                  "puback_lost",
                                                  "puback_repeated",
                                                  "suback_failed",
                                                  "command_after_outage",
                                                  "command_repeated",
                                                  "command_before_suback",
                                                  "published_gap_quota",
                                                  "published_gap_too_large"};

std::string replay(const Options& options, std::uint64_t seed) {
    return "takt-gateway-sim " + seeds::replay_arguments(options, seed);
}

void print_violations(const RunResult& result, const Options& options) {
    std::string text = "seed " + std::to_string(result.seed) + ":\n";
    for (const auto& violation : result.violations) {
        char time[40];
        std::snprintf(time, sizeof time, "%.3f ms",
                      static_cast<double>(violation.t.time_since_epoch().count()) / 1e6);
        text += "  " + std::string(violation.rule) + " at " + time + "\n    expected: " + violation.expected +
                "\n    seen:     " + violation.seen + "\n";
    }
    text += "  again: " + replay(options, result.seed) + " --trace\n";
    std::fputs(text.c_str(), stderr);
}

seeds::Record run_seed(const Options& options, std::uint64_t seed) {
    const RunResult result = run({.seed = seed, .length = options.length(), .trace = options.trace});
    if (!result.violations.empty()) print_violations(result, options);
    seeds::Record record{.seed = seed, .hash = result.hash, .counts = result.counts};
    if (!result.violations.empty()) record.invariant = result.violations.front().rule;
    return record;
}

std::vector<std::string> missing_kinds(const seeds::Counts& total) {
    std::vector<std::string> missing;
    for (const auto kind : kKinds)
        if (!total.contains(std::string(kind))) missing.emplace_back(kind);
    return missing;
}

int print_project(const Options& options) {
    const auto scenario = draw_scenario(options.first, options.length());
    std::cout << scenario.text;
    if (!scenario.error.empty()) std::cerr << "takt-gateway-sim: " << scenario.error << "\n";
    return scenario.error.empty() ? 0 : 2;
}

int run_program(std::span<char*> arguments) {
    Options options;
    if (const auto wrong = parse_options(arguments, options)) {
        std::cerr << "takt-gateway-sim: " << *wrong << "\n";
        return 2;
    }
    if (options.help) {
        std::cout << usage();
        return 0;
    }
    if (options.print_project) return print_project(options);
    return seeds::run_seeds(options, {.name = "takt-gateway-sim",
                                      .run = [&](std::uint64_t seed) { return run_seed(options, seed); },
                                      .replay = [&](std::uint64_t seed) { return replay(options, seed); },
                                      .missing_kinds = missing_kinds,
                                      .shown = "samples_published"});
}

}  // namespace
}  // namespace takt::gatewaysim

int main(int argc, char** argv) {
    return takt::gatewaysim::run_program(std::span(argv, static_cast<std::size_t>(argc)).subspan(1));
}
