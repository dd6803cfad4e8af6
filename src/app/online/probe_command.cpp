// takt probe: which items of each area a device has.
#include "commands.hpp"

#include "online/one_off.hpp"
#include "output.hpp"
#include "progress.hpp"
#include "takt/bus/device_probe.hpp"
#include "takt/client/probe_connection.hpp"
#include "takt/report/states/probe_report.hpp"
#include "texts.hpp"

namespace takt::app {
namespace {

void print_findings(const Texts& texts, const ProbeOptions& options, const bus::ProbeFindings& findings,
                    const report::ProbeRun& run) {
    if (options.json) print(report::probe_json(findings, run).dump() + '\n');
    if (options.yaml) print(report::probe_yaml(findings));
    if (!options.json && !options.yaml) print(report::probe_text(findings));
    print_status(report::probe_summary(texts, findings, run));
    if (findings.lost) print_error(texts.describe(*findings.lost));
    if (run.interrupted) print_status(texts("app.interrupted") + '\n');
}

ExitCode probe_target(const Texts& texts, const ProbeOptions& options) {
    const auto start = line::now();
    const auto one_off = OneOff::open(texts, options);
    if (!one_off) return ended_by(texts, one_off.error());
    auto& device = (*one_off)->device();
    Progress progress(texts, start);
    client::ProbeConnection connection(device);
    const auto findings = bus::probe_device(
        {options.areas, options.first, options.last, options.step, options.max_requests}, connection,
        [&](const bus::ProbeProgress& at) {
            progress.show(line::now(), {std::min(at.asked, at.expected), at.expected, device.transmissions()},
                          report::probe_progress(at));
        });
    progress.clear();
    if (findings.no_answer) return ended_by(texts, *findings.no_answer);
    print_findings(
        texts, options, findings,
        {options.target, options.unit, device.transmissions(), line::now() - start, device.interrupted()});
    if (!findings.complete()) return ExitCode::partly;
    return findings.any_readable() ? ExitCode::ok : ExitCode::no;
}

}  // namespace

ExitCode probe(const CommonOptions& common, const ProbeOptions& options) {
    const Texts texts(common.language);
    if (options.first > options.last)
        return ended_by(texts, fail(Code::out_of_range, "--to", options.last, options.first, 65535).error());
    return probe_target(texts, options);
}

}  // namespace takt::app
