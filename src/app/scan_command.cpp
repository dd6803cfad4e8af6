// takt scan: ports and hosts side by side, the settings of a port one after the other.
#include "takt/app/scan_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "takt/app/console.hpp"
#include "takt/app/port_scan.hpp"
#include "takt/app/progress.hpp"
#include "takt/app/stop_signals.hpp"
#include "takt/app/texts.hpp"
#include "takt/app/traffic_log.hpp"
#include "takt/discover/number_list.hpp"
#include "takt/file/write.hpp"
#include "takt/line/loop.hpp"
#include "takt/line/target.hpp"
#include "takt/report/scan_report.hpp"

namespace takt::app {
namespace {

using namespace std::chrono_literals;
using discover::ScanOutcome;
using discover::ScanTarget;

constexpr std::size_t kSideBySide = 32;
constexpr Duration kRedrawEvery = 100ms;

Result<discover::SerialChoices> choices_of(const ScanOptions& options) {
    discover::SerialChoices choices;
    if (!options.bauds.empty()) {
        TAKT_TRY(choices.bauds, discover::parse_numbers("--bauds", options.bauds, 50, 4'000'000));
    }
    if (!options.parities.empty()) {
        TAKT_TRY(choices.parities, discover::parse_parities(options.parities));
    }
    if (!options.stop_bits.empty()) {
        TAKT_TRY(choices.stop_bits, discover::parse_numbers("--stop-bits", options.stop_bits, 1, 2));
    }
    return choices;
}

/// The ports or hosts that one URL names.
Result<std::vector<ScanTarget>> targets_of(const std::string& url, const discover::SerialChoices& choices) {
    TAKT_TRY(const auto range, discover::parse_url_range(url));
    TAKT_TRY(const auto target, line::parse_target(range ? range->first_url : url));
    const auto line = target.as_line();
    if (range) return discover::host_targets(line, range->hosts);
    if (line.transport == model::Transport::serial)
        return std::vector<ScanTarget>{discover::serial_target(line, url, choices)};
    return std::vector<ScanTarget>{{{line}, false}};
}

Result<std::vector<ScanTarget>> all_targets(const ScanOptions& options) {
    TAKT_TRY(const auto choices, choices_of(options));
    std::vector<ScanTarget> targets;
    for (const auto& url : options.targets) {
        TAKT_TRY(auto named, targets_of(url, choices));
        TAKT_CHECK(discover::add_targets(targets, std::move(named), url));
    }
    return targets;
}

class Scan final : private discover::ScanObserver {
public:
    Scan(const Texts& texts, const ScanOptions& options)
        : texts_(texts), options_(options), progress_(texts, line::now()), start_(line::now()) {}

    ExitCode run() {
        if (const auto ready = prepare(); !ready) return ended_by(texts_, ready.error());
        begin_more();
        redraw_->set(line::now());
        loop_->run_until([this] { return running_ == 0; }, std::chrono::hours(24 * 365));
        progress_.clear();
        summarize();
        if (options_.json) print(report::scan_json(texts_, findings_).dump() + '\n');
        print_status(report::scan_summary(texts_, findings_));
        const auto written = write_project();
        return written == ExitCode::ok ? code() : written;
    }

private:
    Result<void> prepare() {
        discover::ScanRequest request{{}, options_.timeout, options_.identify, options_.thorough};
        TAKT_TRY(request.units, discover::parse_numbers("--units", options_.units, 0, 255));
        TAKT_TRY(auto targets, all_targets(options_));
        TAKT_TRY(loop_, line::Loop::create());
        if (!options_.traffic.empty()) {
            TAKT_TRY(traffic_, TrafficLog::open(options_.traffic));
        }
        TAKT_CHECK(on_stop(*loop_, [this] {
            interrupted_ = true;
            loop_->stop();
        }));
        for (auto& target : targets) TAKT_CHECK(add_scan(request, std::move(target)));
        redraw_ = std::make_unique<line::Timer>(*loop_, [this](Instant t) { redraw(t); });
        return {};
    }

    Result<void> add_scan(const discover::ScanRequest& request, ScanTarget target) {
        PortScan::Options options{.log = traffic_.get(), .on_end = [this] { end_one(); }};
        TAKT_TRY(options.scan.scan, discover::scan_config(request, target));
        options.scan.first_only = options_.first;
        discover::ScanObserver& observer = *this;
        scans_.push_back(std::make_unique<PortScan>(*loop_, std::move(target), std::move(options), observer));
        return {};
    }

    void begin_more() {
        for (auto& scan : scans_) {
            if (running_ >= kSideBySide) return;
            if (scan->begun()) continue;
            ++running_;
            scan->begin();
        }
    }

    void end_one() {
        --running_;
        begin_more();
    }

    void redraw(Instant t) {
        report::Done done;
        for (const auto& scan : scans_) {
            done.done += scan->scan().done();
            done.total += scan->scan().total();
            done.requests += scan->scan().requests();
        }
        const auto shown = std::ranges::find_if(
            scans_, &PortScan::running, [](const auto& scan) -> auto& { return *scan; });
        if (shown != scans_.end())
            progress_.show(t, done, report::scan_progress(texts_, (*shown)->scan(), findings_));
        redraw_->set(after(t, kRedrawEvery));
    }

    // discover::ScanObserver
    void on_device(const discover::FoundDevice& device) override {
        findings_.devices.push_back(device);
        if (options_.json) return;
        progress_.clear();
        print(report::device_line(texts_, device) + '\n');
    }
    void on_trouble(const discover::ScanTrouble& trouble) override {
        findings_.troubles.push_back(trouble);
        progress_.clear();
        print_error(report::trouble_line(texts_, trouble));
    }
    void on_absent_host() override { ++findings_.absent_hosts; }

    void summarize() {
        findings_.complete = !interrupted_;
        findings_.duration = line::now() - start_;
        for (const auto& scan : scans_) {
            findings_.requests += scan->scan().requests();
            findings_.reached = findings_.reached || scan->scan().reached();
        }
    }

    ExitCode write_project() const {
        if (options_.project.empty()) return ExitCode::ok;
        if (findings_.devices.empty()) {
            print_status(texts_("app.scan.no_project", {{"file", options_.project}}) + '\n');
            return ExitCode::ok;
        }
        const auto written =
            file::write_file(options_.project, report::scan_project(texts_, findings_), options_.force);
        if (!written) {
            print_error(report::unwritten_text(texts_, options_.project, written.error()));
            return ExitCode::partly;
        }
        print_status(texts_("app.scan.project_written", {{"file", options_.project}}) + '\n');
        return ExitCode::ok;
    }

    [[nodiscard]] ExitCode code() const {
        switch (discover::outcome_of(findings_)) {
            case ScanOutcome::found: return ExitCode::ok;
            case ScanOutcome::nothing: return ExitCode::no;
            case ScanOutcome::failed: return exit_code(*discover::first_failure(findings_));
            case ScanOutcome::partly: break;
        }
        return ExitCode::partly;
    }

    Texts texts_;
    const ScanOptions& options_;
    Progress progress_;
    Instant start_;
    discover::ScanFindings findings_;
    std::unique_ptr<line::Loop> loop_;
    std::unique_ptr<TrafficLog> traffic_;
    std::vector<std::unique_ptr<PortScan>> scans_;
    std::unique_ptr<line::Timer> redraw_;
    std::size_t running_ = 0;
    bool interrupted_ = false;
};

}  // namespace

ExitCode scan(const CommonOptions& common, const ScanOptions& options) {
    return Scan(Texts(common.language), options).run();
}

}  // namespace takt::app
