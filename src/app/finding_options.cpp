// scan and probe.
#include <algorithm>

#include "command_line.hpp"

namespace takt::app {
namespace {

void add_scan(CLI::App& app, CommandLine& line) {
    auto& options = line.scan;
    auto& scan =
        add_command(app, line, "scan", "help.scan", [&] { return app::scan(line.common, line.scan); });
    scan.add_option("target", options.targets, "help.scan.targets")
        ->required()
        ->expected(1, 64)
        ->type_name("TARGET");
    scan.add_option("--units", options.units, "help.scan.units")->type_name("LIST")->capture_default_str();
    scan.add_option("--bauds", options.bauds, "help.scan.bauds")->type_name("LIST");
    scan.add_option("--parities", options.parities, "help.scan.parities")->type_name("LIST");
    scan.add_option("--stop-bits", options.stop_bits, "help.scan.stop_bits")->type_name("LIST");
    add_timeout(scan, options.timeout, "help.scan.timeout");
    scan.add_flag("--first", options.first, "help.scan.first");
    scan.add_flag("--thorough", options.thorough, "help.scan.thorough");
    scan.add_flag("!--no-identify", options.identify, "help.scan.no_identify");
    scan.add_flag("--json", options.json, "help.scan.json");
    scan.add_option("--project", options.project, "help.scan.project")->type_name("FILE.yaml");
    scan.add_flag("--force", options.force, "help.scan.force");
    scan.add_option("--traffic", options.traffic, "help.traffic")->type_name("FILE");
}

void add_probe(CLI::App& app, CommandLine& line) {
    auto& options = line.probe;
    options.attempts = 2;
    options.reconnect = true;
    options.adaptive = true;
    auto& probe =
        add_command(app, line, "probe", "help.probe", [&] { return app::probe(line.common, line.probe); });
    add_client(probe, options);
    probe
        .add_option_function<std::string>(
            "--area",
            [&options](const std::string& words) {
                for (std::size_t begin = 0; begin <= words.size();) {
                    const auto end = std::min(words.find(',', begin), words.size());
                    const auto found = kAreas.find(words.substr(begin, end - begin));
                    if (found == kAreas.end())
                        throw CLI::ValidationError(
                            "--area",
                            "'" + words + "' is not known, allowed: coils, discrete, holding, input");
                    options.areas.push_back(found->second);
                    begin = end + 1;
                }
            },
            "help.probe.area")
        ->type_name("AREA");
    probe.add_option("--from", options.first, "help.probe.from")->capture_default_str();
    probe.add_option("--to", options.last, "help.probe.to")->capture_default_str();
    probe
        .add_option_function<int>(
            "--step", [&](int step) { options.step = static_cast<std::uint16_t>(step); }, "help.probe.step")
        ->check(CLI::Range(1, 65535))
        ->type_name("N");
    probe.add_option("--max-requests", options.max_requests, "help.probe.max_requests")
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    probe.add_flag("--yaml", options.yaml, "help.probe.yaml");
}

}  // namespace

void add_finding_commands(CLI::App& app, CommandLine& line) {
    add_scan(app, line);
    add_probe(app, line);
}

}  // namespace takt::app
