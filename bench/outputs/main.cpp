// Outputs beside the polling: how punctually devices are polled while a broker is dead, slow and back; and a
// million samples that wait, delivered in order within 64 MB of memory.
//
// The devices are sockets of another process (bench/scale), the broker is mosquitto.
// usage: takt_bench_outputs [--only polling|backlog] [--devices N] [--seconds S] [--samples N] [--runs N]
//                           [--directory D] [--json]
// The exit code is 1 if a limit below is exceeded.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "backlog.hpp"
#include "polling.hpp"
#include "report.hpp"

namespace {

using namespace takt::bench;

constexpr std::uint64_t kMostKib = 64'000'000 / 1024;
constexpr int kFieldProcessor = 1;

struct Options {
    PollingOptions polling;
    BacklogOptions backlog;
    int runs = 3;
    std::string only;
    std::string directory = "/var/tmp";
    bool json = false;
    [[nodiscard]] bool wants(const char* part) const { return only.empty() || only == part; }
};

std::optional<Options> parse(int count, char** arguments) {
    Options options;
    options.backlog.program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "takt";
    for (int i = 1; i < count; ++i) {
        const std::string argument = arguments[i];
        if (argument == "--json") {
            options.json = true;
            continue;
        }
        if (i + 1 == count) return std::nullopt;
        const char* const value = arguments[++i];
        const auto number = [value](long least, long most) {
            return std::clamp(std::strtol(value, nullptr, 10), least, most);
        };
        if (argument == "--only")
            options.only = value;
        else if (argument == "--devices")
            options.polling.devices = options.backlog.devices = static_cast<std::size_t>(number(1, 10'000));
        else if (argument == "--seconds")
            options.polling.seconds = static_cast<int>(number(2, 600));
        else if (argument == "--samples")
            options.backlog.samples = static_cast<std::size_t>(number(1000, 100'000'000));
        else if (argument == "--runs")
            options.runs = static_cast<int>(number(1, 99));
        else if (argument == "--directory")
            options.directory = value;
        else
            return std::nullopt;
    }
    return options;
}

bool measure_backlog_runs(const Options& options, const Field& field, const WorkingFolder& folder,
                          nlohmann::json& report) {
    if (!options.json) print_head(options.backlog);
    bool reached = true;
    for (int i = 0; i < options.runs; ++i) {
        const auto measured = measure_backlog(options.backlog, field, folder);
        reached = reached && measured.is_complete() && measured.peak_kib <= kMostKib;
        report["backlog"].push_back(to_json(measured));
        if (!options.json) print(measured);
    }
    return reached;
}

void measure_polling_runs(const Options& options, const Field& field, const WorkingFolder& folder,
                          nlohmann::json& report) {
    if (!options.json) print_head(options.polling);
    std::vector<PollingRun> runs;
    for (int i = 0; i < options.runs; ++i) {
        runs.push_back(measure_polling(options.polling, field, folder));
        report["polling"]["runs"].push_back(to_json(runs.back()));
        if (!options.json) print(runs.back());
    }
    const auto ratios = ratios_of(runs);
    report["polling"]["ratios"] = to_json(ratios);
    if (!options.json) print(ratios);
}

}  // namespace

int main(int count, char** arguments) {
    const auto options = parse(count, arguments);
    if (!options) {
        fmt::print(stderr,
                   "usage: takt_bench_outputs [--only polling|backlog] [--devices N] [--seconds S] "
                   "[--samples N] [--runs N] [--directory D] [--json]\n");
        return 2;
    }
    try {
        catch_signals();
        const Field field(options->polling.devices, kFieldProcessor);
        if (!field.ok()) throw Failure("the devices cannot listen");
        const WorkingFolder folder(options->directory);
        nlohmann::json report;
        if (options->wants("polling")) measure_polling_runs(*options, field, folder, report);
        const bool reached =
            !options->wants("backlog") || measure_backlog_runs(*options, field, folder, report);
        if (options->json) fmt::print("{}\n", nlohmann::json{{"outputs", report}}.dump());
        return reached ? 0 : 1;
    } catch (const Failure& failure) {
        fmt::print(stderr, "bench: {}\n", failure.what());
        return 1;
    }
}
