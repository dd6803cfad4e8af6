#include "report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

namespace takt::bench {
namespace {

double median(std::vector<double> figures) {
    std::ranges::sort(figures);
    return figures.empty() ? 0 : figures[figures.size() / 2];
}

double in_units_of(double figure, double unit) {
    return unit > 0 ? figure / unit : 0;
}

}  // namespace

std::vector<PhaseRatio> ratios_of(const std::vector<PollingRun>& runs) {
    std::vector<PhaseRatio> ratios;
    for (std::size_t k = 0; k < runs.front().size(); ++k) {
        std::vector<double> p99;
        std::vector<double> usual_p99;
        for (const auto& run : runs) {
            p99.push_back(in_units_of(run[k].p99_us, run[0].p99_us));
            usual_p99.push_back(in_units_of(run[k].usual_p99_us, run[0].usual_p99_us));
        }
        ratios.push_back({runs.front()[k].name, median(p99), median(usual_p99)});
    }
    return ratios;
}

void print_head(const PollingOptions& options) {
    fmt::print("{} devices with {} values, one request a second each; phases of {} s\n", options.devices,
               options.variables, options.seconds);
    fmt::print("  {:<16} {:>7} {:>7} {:>38} {:>9} {:>9} {:>9} {:>9}\n", "", "polls", "missed",
               "lateness, us: p50, p99, usual p99, max", "process", "sampled/s", "deliv./s", "waiting");
}

void print(const PollingRun& run) {
    for (const auto& phase : run)
        fmt::print(
            "  {:<16} {:>7} {:>7} {:>8.0f} {:>9.0f} {:>9.0f} {:>9.0f} {:>7.1f} % {:>9.0f} {:>9.0f} {:>9}\n",
            phase.name, phase.polls, phase.missed, phase.p50_us, phase.p99_us, phase.usual_p99_us,
            phase.most_us, phase.processor * 100, phase.sampled, phase.delivered, phase.waiting);
    fmt::print("\n");
    (void)std::fflush(stdout);
}

void print(const std::vector<PhaseRatio>& ratios) {
    fmt::print("  in units of the first phase, medians: {:>9} {:>9}\n", "p99", "usual p99");
    for (const auto& ratio : ratios)
        fmt::print("  {:<36} {:>9.2f} {:>9.2f}\n", ratio.name, ratio.p99, ratio.usual_p99);
    fmt::print("\n");
}

nlohmann::json to_json(const PollingRun& run) {
    nlohmann::json object;
    for (const auto& phase : run)
        object[phase.name] = {{"polls", phase.polls},
                              {"missed", phase.missed},
                              {"p50_us", phase.p50_us},
                              {"p99_us", phase.p99_us},
                              {"usual_p99_us", phase.usual_p99_us},
                              {"max_us", phase.most_us},
                              {"processor", phase.processor},
                              {"sampled_per_s", phase.sampled},
                              {"delivered_per_s", phase.delivered},
                              {"waiting", phase.waiting},
                              {"dropped", phase.dropped}};
    return object;
}

nlohmann::json to_json(const std::vector<PhaseRatio>& ratios) {
    nlohmann::json object;
    for (const auto& ratio : ratios)
        object[ratio.name] = {{"p99", ratio.p99}, {"usual_p99", ratio.usual_p99}};
    return object;
}

nlohmann::json to_json(const BacklogMeasured& measured) {
    return {{"plain_per_s", measured.plain_per_s}, {"takt_per_s", measured.takt_per_s},
            {"seconds", measured.seconds},         {"samples_at_start", measured.at_start},
            {"samples_at_end", measured.at_end},   {"delivered", measured.delivered},
            {"repeated", measured.repeated},       {"out_of_order", measured.out_of_order},
            {"waiting", measured.waiting},         {"dropped", measured.dropped},
            {"peak_kib", measured.peak_kib},       {"processor", measured.processor}};
}

void print_head(const BacklogOptions& options) {
    fmt::print("{} samples wait, {} new ones a second\n", options.samples,
               options.devices * options.variables);
    fmt::print("  {:>12} {:>12} {:>7} {:>9} {:>9} {:>9} {:>13} {:>9} {:>9}\n", "plain, msg/s", "takt, msg/s",
               "ratio", "seconds", "new", "repeated", "out of order", "peak, MB", "processor");
}

void print(const BacklogMeasured& measured) {
    fmt::print("  {:>12.0f} {:>12.0f} {:>7.2f} {:>9.0f} {:>9} {:>9} {:>13} {:>9.1f} {:>7.0f} %{}\n",
               measured.plain_per_s, measured.takt_per_s, measured.takt_per_s / measured.plain_per_s,
               measured.seconds, measured.at_end - measured.at_start, measured.repeated,
               measured.out_of_order, static_cast<double>(measured.peak_kib) * 1024 / 1e6,
               measured.processor * 100, measured.is_complete() ? "" : "  incomplete");
}

}  // namespace takt::bench
