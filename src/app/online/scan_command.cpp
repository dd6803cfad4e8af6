// takt scan: ports and hosts side by side, the settings of a port one after the other.
#include "commands.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "online/one_off.hpp"
#include "output.hpp"
#include "progress.hpp"
#include "takt/bus/number_list.hpp"
#include "takt/client/port_scan.hpp"
#include "takt/client/probe_connection.hpp"
#include "takt/file/write.hpp"
#include "takt/line/loop.hpp"
#include "takt/model/target_url.hpp"
#include "takt/report/states/probe_report.hpp"
#include "takt/report/states/scan_report.hpp"
#include "texts.hpp"
#include "work_loop.hpp"

namespace takt::app {
namespace {

using namespace std::chrono_literals;
using bus::ScanOutcome;

constexpr Duration kScanRedrawEvery = 100ms;

/// Adds the name of the option to the error of its list, and a correct form where it cannot be read.
template <class T>
Result<T> of_option(Result<T> read, std::string_view option, std::string_view example = {}) {
    if (read) return read;
    auto error = read.error();
    std::string subject(option);
    if (error.code == Code::syntax)
        subject.append(" ").append(error.subject.view()).append(" → ").append(example);
    error.subject.assign(subject);
    return std::unexpected(error);
}

Result<bus::SerialChoices> choices_of(const ScanOptions& options) {
    bus::SerialChoices choices;
    if (!options.bauds.empty()) {
        TAKT_TRY(choices.bauds,
                 of_option(bus::parse_numbers(options.bauds, 50, 4'000'000), "--bauds", "9600,19200"));
    }
    if (!options.parities.empty()) {
        TAKT_TRY(choices.parities,
                 of_option(bus::parse_parities(options.parities), "--parities", "none,even,odd"));
    }
    if (!options.stop_bits.empty()) {
        TAKT_TRY(choices.stop_bits,
                 of_option(bus::parse_numbers(options.stop_bits, 1, 2), "--stop-bits", "1,2"));
    }
    return choices;
}

class Scan final : private bus::ScanObserver {
public:
    Scan(const Texts& texts, const ScanOptions& options)
        : texts_(texts), options_(options), progress_(texts, line::now()), start_(line::now()) {}

    ExitCode run() {
        if (const auto ready = prepare(); !ready) return ended_by(texts_, ready.error());
        scans_->begin();
        redraw_->set(line::now());
        work_loop_.loop().run_until([this] { return scans_->ended(); }, std::chrono::hours(24 * 365));
        progress_.clear();
        summarize();
        if (options_.json) print(report::scan_json(texts_, findings_).dump() + '\n');
        print_status(report::scan_summary(texts_, findings_));
        if (options_.probe) probe_devices();
        const auto written = write_project();
        return written == ExitCode::ok ? code() : written;
    }

private:
    Result<void> prepare() {
        bus::ScanRequest request{{}, options_.timeout, options_.identify, options_.thorough};
        if (!options_.units.empty()) {
            TAKT_TRY(request.units,
                     of_option(bus::parse_numbers(options_.units, 0, 255), "--units", "1-10,16"));
        }
        TAKT_TRY(const auto choices, choices_of(options_));
        TAKT_TRY(auto targets, client::scan_targets(options_.targets, choices));
        TAKT_CHECK(work_loop_.begin(options_.traffic, {}, texts_));
        auto& loop = work_loop_.loop();
        bus::ScanObserver& observer = *this;
        scans_.emplace(loop, observer);
        for (auto& target : targets) TAKT_CHECK(add_scan(request, std::move(target)));
        redraw_ = std::make_unique<line::Timer>(loop, [this](Instant t) { redraw(t); });
        return {};
    }

    Result<void> add_scan(const bus::ScanRequest& request, bus::ScanTarget target) {
        client::PortScan::Options options{
            .traffic = console::traffic_factory(work_loop_.traffic(), console::LineTraffic::Side::master)};
        TAKT_TRY(options.scan.scan, of_option(bus::scan_config(request, target), "--units"));
        options.scan.first_only = options_.first;
        scans_->add(std::move(target), std::move(options));
        return {};
    }

    void redraw(Instant t) {
        const auto totals = scans_->totals();
        if (const auto* const scan = scans_->current())
            progress_.show(t, {totals.done, totals.total, totals.requests},
                           report::scan_progress(texts_, *scan, findings_));
        redraw_->set(after(t, kScanRedrawEvery));
    }

    // bus::ScanObserver
    void on_device(const bus::FoundDevice& device) override {
        findings_.devices.push_back(device);
        if (options_.json) return;
        progress_.clear();
        print(report::device_line(texts_, device) + '\n');
    }
    void on_trouble(const bus::ScanTrouble& trouble) override {
        findings_.troubles.push_back(trouble);
        progress_.clear();
        print_error(report::trouble_line(texts_, trouble));
    }
    void on_absent_host() override { ++findings_.absent_hosts; }

    void summarize() {
        const auto totals = scans_->totals();
        findings_.complete = !work_loop_.loop().stopped();
        findings_.duration = line::now() - start_;
        findings_.requests = totals.requests;
        findings_.reached = totals.reached;
    }

    // The devices of the project one after the other. A device that cannot be probed stays in it without
    // ranges.
    void probe_devices() {
        redraw_.reset();
        scans_.reset();
        const auto project = bus::found_project(findings_);
        for (const auto& line : project.lines)
            for (const auto* device : line.found) {
                if (!work_loop_.loop().stopped()) probe_device(*device);
                findings_.complete = findings_.complete && !work_loop_.loop().stopped();
            }
    }

    void probe_device(const bus::FoundDevice& found) {
        client::Options options{.target = model::url_of(found.line), .unit = found.unit.unit.value};
        options.timeout = options_.timeout.value_or(options.timeout);
        options.attempts = 2;
        options.adaptive = options.reconnect = true;
        const Instant start = line::now();
        const auto opened = client::Client::open(
            work_loop_.loop(), options,
            console::traffic_factory(work_loop_.traffic(), console::LineTraffic::Side::master));
        if (!opened) return probe_failed(opened.error());
        auto& device = **opened;
        client::ProbeConnection connection(device);
        auto findings = bus::probe_device({}, connection, [&](const bus::ProbeProgress& at) {
            progress_.show(line::now(),
                           {std::min(at.asked, at.expected), at.expected, device.transmissions()},
                           report::probe_progress(at));
        });
        progress_.clear();
        if (findings.no_answer) return probe_failed(*findings.no_answer);
        print_status(fmt::format("{} --unit {}:\n", options.target, options.unit));
        print_status(report::probe_summary(texts_, findings,
                                           {.target = options.target,
                                            .unit = options.unit,
                                            .transmissions = device.transmissions(),
                                            .duration = line::now() - start}));
        report_lengths_off(texts_, device);
        if (findings.lost) probe_failed(*findings.lost);
        findings_.complete = findings_.complete && findings.complete();
        probes_.emplace(&found, std::move(findings));
    }

    void probe_failed(const Error& error) {
        print_error(texts_.describe(error));
        findings_.complete = false;
    }

    ExitCode write_project() const {
        if (options_.project.empty()) return ExitCode::ok;
        if (findings_.devices.empty()) {
            print_status(texts_("app.scan.no_project", {{"file", options_.project}}) + '\n');
            return ExitCode::ok;
        }
        const auto written = file::write_file(
            options_.project, report::scan_project(texts_, findings_, probes_), options_.force);
        if (!written)
            return ended_with(report::unwritten_text(texts_, options_.project, written.error()),
                              ExitCode::partly);
        print_status(texts_("app.scan.project_written", {{"file", options_.project}}) + '\n');
        return ExitCode::ok;
    }

    [[nodiscard]] ExitCode code() const {
        switch (bus::outcome_of(findings_)) {
            case ScanOutcome::found: return ExitCode::ok;
            case ScanOutcome::nothing: return ExitCode::no;
            case ScanOutcome::failed: return exit_code(*bus::first_failure(findings_));
            case ScanOutcome::partly: break;
        }
        return ExitCode::partly;
    }

    Texts texts_;
    const ScanOptions& options_;
    Progress progress_;
    Instant start_;
    bus::ScanFindings findings_;
    bus::DeviceProbes probes_;
    WorkLoop work_loop_;
    std::optional<client::PortScans> scans_;
    std::unique_ptr<line::Timer> redraw_;
};

}  // namespace

ExitCode scan(const CommonOptions& common, const ScanOptions& options) {
    return Scan(Texts(common.language), options).run();
}

}  // namespace takt::app
