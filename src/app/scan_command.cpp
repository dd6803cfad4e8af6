// takt scan: a LineScan for each setting of each port and for each host; ports and hosts side by side, the
// settings of a port one after the other.
#include "takt/app/scan_command.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <utility>

#include "takt/app/console.hpp"
#include "takt/app/place_scan.hpp"
#include "takt/app/progress.hpp"
#include "takt/app/scan_places.hpp"
#include "takt/app/stop_signals.hpp"
#include "takt/app/texts.hpp"
#include "takt/app/traffic_log.hpp"
#include "takt/file/write.hpp"
#include "takt/line/loop.hpp"
#include "takt/model/target_url.hpp"
#include "takt/report/scan_report.hpp"

namespace takt::app {
namespace {

using namespace std::chrono_literals;

constexpr Duration kSerialWait = 100ms;
constexpr Duration kStreamWait = 1s;
constexpr Duration kLeastPatience = 500ms;
constexpr std::size_t kSideBySide = 32;
constexpr std::uint32_t kLastSerialUnit = 247;

class Scan final : private ScanNews {
public:
    Scan(const Texts& texts, const ScanOptions& options)
        : texts_(texts), options_(options), progress_(texts, line::now()), start_(line::now()) {}

    ExitCode run() {
        if (const auto ready = prepare(); !ready) return ended_by(texts_, ready.error());
        begin_more();
        redraw_->set(line::now());
        loop_->run_until([this] { return running_ == 0; }, std::chrono::hours(24 * 365));
        progress_.clear();
        findings_.complete = !interrupted_;
        findings_.duration = line::now() - start_;
        for (const auto& place : places_) findings_.requests += place->requests();
        tell();
        const auto written = write_project();
        return written == ExitCode::ok ? code() : written;
    }

private:
    Result<void> prepare() {
        TAKT_TRY(const auto units, parse_numbers("--units", options_.units, 0, 255));
        LineSettings settings;
        if (!options_.bauds.empty()) {
            TAKT_TRY(settings.bauds, parse_numbers("--bauds", options_.bauds, 50, 4'000'000));
        }
        if (!options_.parities.empty()) {
            TAKT_TRY(settings.parities, parse_parities(options_.parities));
        }
        if (!options_.stop_bits.empty()) {
            TAKT_TRY(settings.stop_bits, parse_numbers("--stop-bits", options_.stop_bits, 1, 2));
        }
        std::vector<ScanPlace> places;
        for (const auto& target : options_.targets) {
            TAKT_TRY(auto named, scan_places(target, settings));
            for (auto& place : named)  // each once, however often it is named
                if (std::ranges::find(places, place.settings, &ScanPlace::settings) == places.end())
                    places.push_back(std::move(place));
            if (places.size() > kMaxScanPlaces)
                return fail(Code::out_of_range, target, static_cast<std::int64_t>(places.size()), 1,
                            kMaxScanPlaces);
        }
        TAKT_TRY(loop_, line::Loop::create());
        if (!options_.traffic.empty()) {
            TAKT_TRY(traffic_, TrafficLog::open(options_.traffic));
        }
        ScanNews& news = *this;
        TAKT_CHECK(on_stop(*loop_, [this] {
            interrupted_ = true;
            loop_->stop();
        }));
        for (const auto& place : places) {
            auto config = config_of(place, units);
            if (config.units.empty())
                return fail(Code::out_of_range, "--units", units[0], 1, kLastSerialUnit);
            places_.push_back(std::make_unique<PlaceScan>(
                *loop_, place, PlaceScan::Options{std::move(config), options_.first, traffic_.get()}, news));
        }
        redraw_ = std::make_unique<line::Timer>(*loop_, [this](Instant t) { redraw(t); });
        return {};
    }

    [[nodiscard]] discover::ScanConfig config_of(const ScanPlace& place,
                                                 const std::vector<std::uint32_t>& units) const {
        const bool serial = place.settings[0].transport == model::Transport::serial;
        discover::ScanConfig config;
        for (const auto unit : units) {
            if (serial && (unit == 0 || unit > kLastSerialUnit)) continue;
            config.units.push_back(UnitId{static_cast<std::uint8_t>(unit)});
        }
        config.wait = options_.timeout.value_or(serial ? kSerialWait : kStreamWait);
        config.patience = std::max(4 * config.wait, kLeastPatience);
        config.identify = options_.identify;
        config.thorough = options_.thorough;
        return config;
    }

    void begin_more() {
        for (auto& place : places_) {
            if (running_ >= kSideBySide) return;
            if (place->begun()) continue;
            ++running_;
            place->begin();
        }
    }

    void redraw(Instant t) {
        Done done;
        const PlaceScan* shown = nullptr;
        for (const auto& place : places_) {
            done.done += place->done();
            done.total += place->total();
            done.requests += place->requests();
            if (place->begun() && !place->ended() && shown == nullptr) shown = place.get();
        }
        if (shown) progress_.show(t, done, what(*shown));
        redraw_->set(after(t, 100ms));
    }

    [[nodiscard]] std::string what(const PlaceScan& place) const {
        const auto& target = place.target();
        auto text = target.transport == model::Transport::serial
                        ? fmt::format("{} {}", target.port, model::settings_text(target.as_line()))
                        : line::host_and_port(target.port, target.tcp_port);
        if (place.settings() > 1) text += fmt::format(" ({}/{})", place.setting(), place.settings());
        return text + ", " + texts_("app.scan.found", {{"count", std::to_string(findings_.devices.size())}});
    }

    // ScanNews
    void on_device(const discover::FoundDevice& device) override {
        findings_.devices.push_back(device);
        if (options_.json) return;
        progress_.clear();
        print(report::device_line(texts_, findings_.devices.back()) + '\n');
    }
    void on_trouble(const discover::ScanTrouble& trouble) override {
        findings_.troubles.push_back(trouble);
        progress_.clear();
        print_error(report::trouble_line(texts_, trouble));
    }
    void on_absent() override { ++findings_.absent_hosts; }
    void on_end() override {
        --running_;
        begin_more();
    }

    void tell() const {
        if (options_.json) print(report::scan_json(texts_, findings_).dump() + "\n");
        Texts::Arguments arguments{{"count", std::to_string(findings_.devices.size())},
                                   {"requests", std::to_string(findings_.requests)},
                                   {"time", rough_time(findings_.duration)},
                                   {"absent", std::to_string(findings_.absent_hosts)}};
        print_status(texts_("app.scan.summary", arguments) + '\n');
        if (findings_.absent_hosts > 0) print_status(texts_("app.scan.absent", arguments) + '\n');
        if (!findings_.complete) print_status(texts_("app.interrupted") + '\n');
    }

    ExitCode write_project() const {
        if (options_.project.empty()) return ExitCode::ok;
        if (findings_.devices.empty()) {
            print_status(texts_("app.scan.no_project", {{"file", options_.project}}) + '\n');
            return ExitCode::ok;
        }
        const auto written =
            file::write_file(options_.project, report::scan_project(texts_, findings_), options_.force);
        if (written) {
            print_status(texts_("app.scan.project_written", {{"file", options_.project}}) + '\n');
            return ExitCode::ok;
        }
        const auto& error = written.error();
        if (error.code == Code::cannot_open && error.numbers[0] == EEXIST)
            print_error(texts_("app.convert.exists", {{"file", options_.project}}));
        else
            print_error(texts_.describe(error));
        return ExitCode::partly;
    }

    [[nodiscard]] ExitCode code() const {
        if (interrupted_) return ExitCode::partly;
        // A bit rate that a port does not have is no failure.
        const auto error = std::ranges::find_if(findings_.troubles, [](const discover::ScanTrouble& trouble) {
            return trouble.kind == discover::ScanTrouble::Kind::error &&
                   trouble.error.code != Code::unsupported && trouble.error.code != Code::out_of_range;
        });
        const bool failed = error != findings_.troubles.end();
        const bool reached = std::ranges::any_of(places_, [](const auto& place) { return place->reached(); });
        if (!findings_.devices.empty()) return failed ? ExitCode::partly : ExitCode::ok;
        if (failed) return reached ? ExitCode::partly : exit_code(error->error);
        return ExitCode::no;
    }

    Texts texts_;
    const ScanOptions& options_;
    Progress progress_;
    Instant start_;
    discover::ScanFindings findings_;
    std::unique_ptr<line::Loop> loop_;
    std::unique_ptr<TrafficLog> traffic_;
    std::vector<std::unique_ptr<PlaceScan>> places_;
    std::unique_ptr<line::Timer> redraw_;
    std::size_t running_ = 0;
    bool interrupted_ = false;
};

}  // namespace

ExitCode scan(const CommonOptions& common, const ScanOptions& options) {
    return Scan(Texts(common.language), options).run();
}

}  // namespace takt::app
