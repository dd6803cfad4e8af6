// Many TCP devices on one thread (issue: "TCP at scale"): the engine of `takt run` with one connection to
// each of 5 000 devices, one request a second each. The devices are real sockets on loopback addresses, in
// another process on the other core.
//
// With --program the same project is run by `takt run`, its output to a file.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>

#include "field.hpp"
#include "measure.hpp"
#include "program.hpp"
#include "report.hpp"
#include "takt/line/descriptors.hpp"

namespace {

using namespace takt;
using namespace std::chrono_literals;

constexpr int kOwnProcessor = 0;
constexpr int kFieldProcessor = 1;
constexpr std::size_t kOwnDescriptors = 32;  // beside one for each device

struct Settings {
    bench::Scale scale;
    std::string program;
    bool json = false;
};

std::optional<Settings> parse(int count, char** arguments) {
    Settings settings;
    for (int i = 1; i < count; ++i) {
        const std::string_view argument = arguments[i];
        const bool more = i + 1 < count;
        if (argument == "--json")
            settings.json = true;
        else if (argument == "--devices" && more)
            settings.scale.devices =
                std::clamp<std::size_t>(std::strtoul(arguments[++i], nullptr, 10), 1, 60000);
        else if (argument == "--seconds" && more)
            settings.scale.time =
                std::clamp<long>(std::strtol(arguments[++i], nullptr, 10), 1, 86400) * Duration(1s);
        else if (argument == "--program" && more)
            settings.program = arguments[++i];
        else
            return std::nullopt;
    }
    return settings;
}

}  // namespace

int main(int count, char** arguments) {
    const auto settings = parse(count, arguments);
    if (!settings) {
        std::fprintf(stderr,
                     "usage: takt_bench_scale [--devices N] [--seconds S] [--program TAKT] [--json]\n");
        return 2;
    }
    bench::Field field(settings->scale.devices, kFieldProcessor);
    const auto allowed = line::raise_descriptor_limit();
    const std::size_t needed = settings->scale.devices + kOwnDescriptors;
    if (!field.ok() || allowed < needed) {
        std::fprintf(stderr, "%zu devices need %zu descriptors; %zu are allowed (ulimit -Hn)\n",
                     settings->scale.devices, needed, allowed);
        return 1;
    }
    if (!settings->program.empty()) {
        const auto measured = bench::run_program(settings->program, settings->scale.devices,
                                                 settings->scale.time, field.port(), kOwnProcessor);
        if (!measured) {
            std::fprintf(stderr, "%s: %s\n", settings->program.c_str(), measured.error().c_str());
            return 1;
        }
        if (settings->json)
            fmt::print("{}\n", nlohmann::json{{"program", to_json(*measured)}}.dump());
        else
            print(*measured);
        return measured->missed == 0 ? 0 : 1;
    }
    bench::pin_to_processor(kOwnProcessor);
    const auto measured = bench::measure_scale(settings->scale, field);
    if (!measured) {
        std::fprintf(stderr, "not all devices could be connected to\n");
        return 1;
    }
    if (settings->json)
        fmt::print("{}\n", nlohmann::json{{"scale", to_json(settings->scale.devices, *measured)}}.dump());
    else
        print(settings->scale.devices, *measured);
    return measured->missed == 0 ? 0 : 1;
}
