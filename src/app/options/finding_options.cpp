// scan and probe.
#include <algorithm>
#include <span>
#include <string>

#include "commands.hpp"
#include "options/add_commands.hpp"
#include "options/shared_options.hpp"
#include "takt/client/port_scan.hpp"

namespace takt::app {
namespace {

void add_scan(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<ScanOptions>();
    auto scan = line.root().command("scan", "help.scan", [&] { return app::scan(common, options); });
    scan.value("TARGET", options.targets, "help.scan.targets")
        .required()
        .count(1, 64)
        .check([](const std::string& url) {
            if (const auto targets = client::scan_targets(std::span(&url, 1), {}); !targets)
                reject(target_error("TARGET", url, targets.error()));
        });
    scan.value("--units", options.units, "help.scan.units").value_name("LIST");
    scan.value("--bauds", options.bauds, "help.scan.bauds").value_name("LIST");
    scan.value("--parities", options.parities, "help.scan.parities").value_name("LIST");
    scan.value("--stop-bits", options.stop_bits, "help.scan.stop_bits").value_name("LIST");
    add_timeout(scan, options.timeout, "help.scan.timeout");
    scan.flag("--first", options.first, "help.scan.first");
    scan.flag("--thorough", options.thorough, "help.scan.thorough");
    scan.flag("!--no-identify", options.identify, "help.scan.no_identify");
    scan.flag("--json", options.json, "help.scan.json");
    auto project = scan.value("--project", options.project, "help.scan.project").value_name("FILE.yaml");
    scan.flag("--probe", options.probe, "help.scan.probe").needs(project);
    scan.flag("--force", options.force, "help.scan.force");
    scan.value("--traffic", options.traffic, "help.traffic").value_name("FILE");
}

void add_probe(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<ProbeOptions>();
    options.attempts = 2;
    options.reconnect = true;
    options.adaptive = true;
    auto probe = line.root().command("probe", "help.probe", [&] { return app::probe(common, options); });
    add_client(probe, options);
    probe
        .text(
            "--area",
            [&options](const std::string& words) {
                for (std::size_t begin = 0; begin <= words.size();) {
                    const auto end = std::min(words.find(',', begin), words.size());
                    const auto found = kAreas.find(words.substr(begin, end - begin));
                    if (found == kAreas.end())
                        reject_word("--area", words, "coils, discrete, holding, input");
                    options.areas.push_back(found->second);
                    begin = end + 1;
                }
            },
            "help.probe.area")
        .value_name("AREA");
    probe.value("--from", options.first, "help.probe.from").show_default();
    probe.value("--to", options.last, "help.probe.to").show_default();
    probe
        .number(
            "--step", [&](int step) { options.step = static_cast<std::uint16_t>(step); }, "help.probe.step")
        .range(1, 65535)
        .value_name("N");
    probe.value("--max-requests", options.max_requests, "help.probe.max_requests")
        .range(1, 1000000)
        .show_default();
    probe.flag("--yaml", options.yaml, "help.probe.yaml");
}

}  // namespace

void add_finding_commands(CommandLine& line, const CommonOptions& common) {
    add_scan(line, common);
    add_probe(line, common);
}

}  // namespace takt::app
