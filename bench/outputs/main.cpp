// Outputs beside the polling: how punctually devices are polled while a broker is dead, slow and back; and a
// million samples that wait, delivered in order within 64 MB of memory.
//
// The devices are sockets of another process (bench/scale), the broker is mosquitto.
// The exit code is 1 if a limit below is exceeded.
#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <vector>

#include "../arguments.hpp"
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

Options options_of(const Arguments& arguments) {
    Options options;
    auto& polling = options.polling;
    auto& backlog = options.backlog;
    backlog.program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "takt";
    polling.devices = arguments.number("--devices", polling.devices, 1, 10'000);
    backlog.devices = arguments.number("--devices", backlog.devices, 1, 10'000);
    polling.seconds = arguments.number("--seconds", polling.seconds, 2, 600);
    backlog.samples = arguments.number("--samples", backlog.samples, 1000, 100'000'000);
    options.runs = arguments.number("--runs", options.runs, 1, 99);
    options.only = arguments.text("--only", options.only);
    options.directory = arguments.text("--directory", options.directory);
    options.json = arguments.json();
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

int run(const Arguments& arguments) {
    const auto options = options_of(arguments);
    const Field field(options.polling.devices, kFieldProcessor);
    if (!field.ok()) throw Failure("the devices cannot listen");
    const WorkingFolder folder(options.directory);
    nlohmann::json report;
    if (options.wants("polling")) measure_polling_runs(options, field, folder, report);
    const bool reached = !options.wants("backlog") || measure_backlog_runs(options, field, folder, report);
    if (options.json) fmt::print("{}\n", nlohmann::json{{"outputs", report}}.dump());
    return reached ? 0 : 1;
}

}  // namespace

int main(int count, char** arguments) {
    return run_benchmark(count, arguments,
                         {{"--only", "polling|backlog"},
                          {"--devices", "N"},
                          {"--seconds", "S"},
                          {"--samples", "N"},
                          {"--runs", "N"},
                          {"--directory", "D"}},
                         run);
}
