// The journal of outputs: samples a second through it on one core, bytes of a sample, and the start with many
// gigabytes in it.
// The exit code is 1 if a limit below is exceeded.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "../arguments.hpp"
#include "../working_folder.hpp"
#include "size.hpp"
#include "speed.hpp"
#include "start.hpp"

namespace {

using namespace takt::bench;

constexpr double kMostSyncs = 10.5;  // a second; the last one comes at the end
constexpr double kMostStart = 1;     // seconds
constexpr std::uint64_t kBytesOfGigabyte = 1'000'000'000;

struct Options {
    SpeedOptions speed;
    std::uint64_t bytes = 10 * kBytesOfGigabyte;
    int runs = 3;
    std::string directory = "/var/tmp";
    bool json = false;
};

double median(std::vector<double> figures) {
    std::ranges::sort(figures);
    return figures.empty() ? 0 : figures[figures.size() / 2];
}

Options options_of(const Arguments& arguments) {
    Options options;
    auto& speed = options.speed;
    speed.per_second = arguments.number("--rate", speed.per_second, 20, 10'000'000);
    speed.seconds = arguments.number("--seconds", speed.seconds, 1, 600);
    options.bytes =
        arguments.number("--gigabytes", options.bytes / kBytesOfGigabyte, 1, 1000) * kBytesOfGigabyte;
    options.runs = arguments.number("--runs", options.runs, 1, 99);
    options.directory = arguments.text("--directory", options.directory);
    options.json = arguments.json();
    return options;
}

bool is_reached(const SpeedMeasured& speed, const SpeedOptions& options) {
    return speed.per_core() >= static_cast<double>(options.per_second) &&
           static_cast<double>(speed.syncs) <= kMostSyncs * speed.seconds;
}

nlohmann::json to_json(const SpeedMeasured& speed) {
    const auto samples = static_cast<double>(speed.samples);
    return {{"samples_per_s", samples / speed.seconds},
            {"samples_per_core_s", speed.per_core()},
            {"processor", speed.processor() / speed.seconds},
            {"ns_per_sample",
             {{"encode", speed.encode / samples * 1e9},
              {"write", speed.write / samples * 1e9},
              {"read", speed.read / samples * 1e9}}},
            {"syncs_per_s", static_cast<double>(speed.syncs) / speed.seconds},
            {"bytes_per_sample", static_cast<double>(speed.disk_bytes) / samples},
            {"longest_tick_ms", speed.longest_tick * 1e3},
            {"most_late_ms", speed.most_late * 1e3}};
}

void print(const nlohmann::json& run) {
    const auto& ns = run["ns_per_sample"];
    fmt::print(
        "  {:>9.0f} {:>10.0f} {:>7.1f} % {:>7.0f} {:>6.0f} {:>6.0f} {:>7.1f} {:>7.1f} {:>9.1f} {:>7.1f}\n",
        run["samples_per_s"].get<double>(), run["samples_per_core_s"].get<double>(),
        run["processor"].get<double>() * 100, ns["encode"].get<double>(), ns["write"].get<double>(),
        ns["read"].get<double>(), run["syncs_per_s"].get<double>(), run["bytes_per_sample"].get<double>(),
        run["longest_tick_ms"].get<double>(), run["most_late_ms"].get<double>());
}

bool measure_speed_runs(const Options& options, const WorkingFolder& folder, nlohmann::json& report) {
    if (!options.json) {
        fmt::print(
            "{} variables, {} samples/s, for {} s: encoded, written, read and acknowledged by one thread\n",
            options.speed.variables, options.speed.per_second, options.speed.seconds);
        fmt::print("  {:>9} {:>10} {:>9} {:>22} {:>7} {:>7} {:>9} {:>7}\n", "samples/s", "of a core", "share",
                   "ns a sample: enc/wr/rd", "syncs/s", "bytes", "tick, ms", "late");
    }
    bool reached = true;
    for (int i = 0; i < options.runs; ++i) {
        const auto measured = measure_speed(options.speed, folder);
        reached = reached && is_reached(measured, options.speed);
        const auto run = to_json(measured);
        if (!options.json) print(run);
        report["speed"].push_back(run);
    }
    return reached;
}

void report_sizes(bool json, nlohmann::json& report) {
    if (!json)
        fmt::print("\nBytes of a sample in the journal\n  {:<38} {:>14} {:>8} {:>8} {:>8}\n", "",
                   "samples/record", "float", "int16", "bool");
    for (const auto& size : measure_sizes()) {
        report["sizes"].push_back(
            {{"plant", size.plant}, {"samples_per_record", size.samples_a_record}, {"bytes", size.bytes}});
        if (!json)
            fmt::print("  {:<38} {:>14.0f} {:>8.1f} {:>8.1f} {:>8.1f}\n", size.plant, size.samples_a_record,
                       size.bytes[0], size.bytes[1], size.bytes[2]);
    }
}

bool report_start(const Options& options, const WorkingFolder& folder, nlohmann::json& report) {
    const auto measured = measure_start(options.bytes, options.runs, folder);
    report["start"] = {{"bytes", measured.bytes},     {"segments", measured.segments},
                       {"waiting", measured.waiting}, {"fill_s", measured.fill},
                       {"cold_s", measured.cold},     {"warm_s", measured.warm}};
    if (!options.json)
        fmt::print(
            "\nStart with {:.1f} GB in {} segments, {:.0f} million samples waiting: not cached {:.3f} s, "
            "cached {:.3f} s (medians of {})\n  filled in {:.0f} s\n",
            static_cast<double>(measured.bytes) / kBytesOfGigabyte, measured.segments,
            static_cast<double>(measured.waiting) / 1e6, median(measured.cold), median(measured.warm),
            options.runs, measured.fill);
    return median(measured.cold) < kMostStart;
}

int run(const Arguments& arguments) {
    const auto options = options_of(arguments);
    const WorkingFolder folder(options.directory);
    nlohmann::json report;
    bool reached = measure_speed_runs(options, folder, report);
    report_sizes(options.json, report);
    reached = report_start(options, folder, report) && reached;
    if (options.json) fmt::print("{}\n", nlohmann::json{{"journal", report}}.dump());
    return reached ? 0 : 1;
}

}  // namespace

int main(int count, char** arguments) {
    return run_benchmark(
        count, arguments,
        {{"--rate", "N"}, {"--seconds", "S"}, {"--gigabytes", "N"}, {"--runs", "N"}, {"--directory", "D"}},
        run);
}
