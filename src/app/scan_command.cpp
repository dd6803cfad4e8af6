// takt scan: a LineScan for each setting of each port and for each host; ports and hosts side by side, the
// settings of a port one after the other.
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <utility>

#include "takt/app/commands.hpp"
#include "takt/app/progress.hpp"
#include "takt/app/project.hpp"
#include "takt/app/scan_places.hpp"
#include "takt/app/scan_report.hpp"
#include "takt/app/stop_signals.hpp"
#include "takt/app/texts.hpp"
#include "takt/app/traffic_log.hpp"
#include "takt/file/write.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/loop.hpp"
#include "takt/line/real_line.hpp"
#include "takt/poll/line_scan.hpp"

namespace takt::app {
namespace {

using namespace std::chrono_literals;

constexpr Duration kSerialWait = 100ms;
constexpr Duration kStreamWait = 1s;
constexpr Duration kLeastPatience = 500ms;
constexpr std::size_t kSideBySide = 32;
constexpr std::uint32_t kLastSerialUnit = 247;
// A connection that is lost counts once, one that cannot be made three times; an answer clears the account.
constexpr int kLinkLost = 1;
constexpr int kNoLink = 3;
constexpr int kMostLinkTrouble = 9;

bus::LineConfig line_config(const line::Target& target) {
    bus::LineConfig config;
    config.framing = target.framing;
    config.format = target.format;
    if (target.transport != model::Transport::serial) config.echo = bus::Echo::absent;
    return line::fit_to_real_line(config, target.as_line());
}

/// What the scan of one place tells on.
class ScanNews {
public:
    virtual void on_device(const line::Target& target, const poll::FoundUnit& unit) = 0;
    virtual void on_trouble(const ScanTrouble& trouble) = 0;
    virtual void on_absent() = 0;
    virtual void on_end() = 0;

protected:
    ~ScanNews() = default;
};

/// One port or host, setting by setting. The driver's engine: hands everything to the scan of the setting.
class PlaceScan final : private Engine {
public:
    PlaceScan(line::Loop& loop, const ScanPlace& place, poll::ScanConfig config, bool first_only,
              TrafficLog* log, ScanNews& news)
        : loop_(loop),
          place_(place),
          config_(std::move(config)),
          first_only_(first_only),
          log_(log),
          news_(news),
          step_(loop, [this](Instant) { next(); }) {}

    void begin() {
        begun_ = true;
        step_.set(line::now());
    }
    [[nodiscard]] bool begun() const { return begun_; }
    [[nodiscard]] bool ended() const { return ended_; }
    [[nodiscard]] bool reached() const { return reached_; }
    [[nodiscard]] const line::Target& target() const {
        return place_.settings[std::min(setting_, place_.settings.size() - 1)];
    }
    [[nodiscard]] std::size_t settings_begun() const { return setting_ + 1; }
    [[nodiscard]] std::size_t settings() const { return place_.settings.size(); }
    [[nodiscard]] std::size_t total() const { return config_.units.size() * settings(); }
    [[nodiscard]] std::size_t done() const {
        if (ended_) return total();
        const std::size_t here = scan_ ? std::min(scan_->visited(), config_.units.size()) : 0;
        return setting_ * config_.units.size() + here;
    }
    [[nodiscard]] std::uint64_t requests() const { return requests_ + (scan_ ? scan_->requests() : 0); }

private:
    // Engine
    void on_link(Instant t, bool up) override {
        scan_->on_link(t, up);
        look();
    }
    void on_bytes(Instant t, Bytes bytes) override {
        scan_->on_bytes(t, bytes);
        look();
    }
    void on_tick(Instant t) override {
        scan_->on_tick(t);
        look();
    }
    Bytes transmit(Instant t) override { return scan_->transmit(t); }
    Instant next_wakeup() const override { return scan_->next_wakeup(); }

    // What is to be done may not be done from within the driver's call.
    void look() {
        for (; told_ < scan_->found().size(); ++told_) {
            news_.on_device(target(), scan_->found()[told_]);
            link_trouble_ = 0;
        }
        if (scan_->finished()) step_.set(line::now());
    }

    void next() {
        if (scan_) close_setting();
        while (!ended_ && !scan_) {
            if (setting_ >= place_.settings.size()) return end();
            if (!open_setting()) ++setting_;
        }
    }

    bool open_setting() {
        config_.line = line_config(target());
        traffic_ = log_ ? std::make_unique<LineTraffic>(*log_, target().as_line(), LineTraffic::Side::master)
                        : nullptr;
        scan_ = std::make_unique<poll::LineScan>(config_, traffic_.get());
        told_ = 0;
        line::DriverOptions options;
        options.connect_limit = std::max<Duration>(config_.wait, kStreamWait);
        options.must_reconnect = [this] { return scan_->must_reconnect(); };
        options.on_link = [this](Instant t, bool up, const std::optional<Error>& why) {
            const bool was_up = std::exchange(up_, up);
            if (up)
                reached_ = true;
            else
                link_trouble(t, was_up, why);
        };
        auto driver = line::open_target(loop_, target(), *this, options);
        if (driver) {
            driver_ = *std::move(driver);
            return true;
        }
        scan_.reset();
        news_.on_trouble({ScanTrouble::Kind::error, target(), driver.error(), 0});
        // A bit rate the port does not have says nothing of the next one.
        const bool of_setting =
            driver.error().code == Code::unsupported || driver.error().code == Code::out_of_range;
        if (!of_setting) end();
        return false;
    }

    void close_setting() {
        driver_.reset();
        requests_ += scan_->requests();
        for (const auto unit : scan_->garbled())
            news_.on_trouble({ScanTrouble::Kind::garbled, target(), {}, unit.value});
        if (scan_->end() == poll::ScanEnd::line_busy)
            news_.on_trouble({ScanTrouble::Kind::busy, target(), {}, 0});
        if (scan_->strangers() > 0) news_.on_trouble({ScanTrouble::Kind::strangers, target(), {}, 0});
        const bool enough = first_only_ && !scan_->found().empty();
        scan_.reset();
        up_ = false;
        ++setting_;
        if (enough || gone_) end();
    }

    // A host is left when it does not take the first connection, or hangs up again and again; the driver
    // tries by itself until then.
    void link_trouble(Instant t, bool was_up, const std::optional<Error>& why) {
        link_trouble_ += was_up ? kLinkLost : kNoLink;
        if (gone_ || (reached_ && link_trouble_ < kMostLinkTrouble)) return;
        gone_ = true;
        const auto lost = fail(Code::connection_lost, target().as_line().name).error();
        if (!reached_ && place_.of_many)
            news_.on_absent();
        else
            news_.on_trouble({ScanTrouble::Kind::error, target(), why.value_or(lost), 0});
        step_.set(t);
    }

    void end() {
        if (std::exchange(ended_, true)) return;
        news_.on_end();
    }

    line::Loop& loop_;
    ScanPlace place_;
    poll::ScanConfig config_;
    bool first_only_;
    TrafficLog* log_;
    ScanNews& news_;
    std::size_t setting_ = 0;
    std::size_t told_ = 0;
    int link_trouble_ = 0;
    bool up_ = false;
    bool gone_ = false;  // the link, for good
    bool begun_ = false;
    bool ended_ = false;
    bool reached_ = false;
    std::uint64_t requests_ = 0;
    std::unique_ptr<LineTraffic> traffic_;
    std::unique_ptr<poll::LineScan> scan_;
    std::unique_ptr<line::Driver> driver_;
    line::Timer step_;
};

class Scan final : private ScanNews {
public:
    Scan(const Texts& texts, const ScanOptions& options)
        : texts_(texts), options_(options), progress_(texts, line::now()), start_(line::now()) {}

    ExitCode run() {
        if (const auto ready = prepare(); !ready) {
            texts_.complain(texts_.describe(ready.error()));
            return exit_code(ready.error());
        }
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
            std::ranges::move(named, std::back_inserter(places));
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
            places_.push_back(std::make_unique<PlaceScan>(*loop_, place, std::move(config), options_.first,
                                                          traffic_.get(), news));
        }
        redraw_ = std::make_unique<line::Timer>(*loop_, [this](Instant t) { redraw(t); });
        return {};
    }

    [[nodiscard]] poll::ScanConfig config_of(const ScanPlace& place,
                                             const std::vector<std::uint32_t>& units) const {
        const bool serial = place.settings[0].transport == model::Transport::serial;
        poll::ScanConfig config;
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
                        ? fmt::format("{} {}", target.port, settings_text(target))
                        : line::host_and_port(target.port, target.tcp_port);
        if (place.settings() > 1)
            text +=
                fmt::format(" ({}/{})", std::min(place.settings_begun(), place.settings()), place.settings());
        return text + ", " + texts_("app.scan.found", {{"count", std::to_string(findings_.devices.size())}});
    }

    // ScanNews
    void on_device(const line::Target& target, const poll::FoundUnit& unit) override {
        findings_.devices.push_back({target, unit});
        if (options_.json) return;
        progress_.clear();
        print(device_line(texts_, findings_.devices.back()) + '\n');
    }
    void on_trouble(const ScanTrouble& trouble) override {
        findings_.troubles.push_back(trouble);
        progress_.clear();
        texts_.complain(trouble_line(texts_, trouble));
    }
    void on_absent() override { ++findings_.absent_hosts; }
    void on_end() override {
        --running_;
        begin_more();
    }

    void tell() const {
        if (options_.json) print(scan_json(texts_, findings_).dump() + "\n");
        Texts::Arguments arguments{{"count", std::to_string(findings_.devices.size())},
                                   {"requests", std::to_string(findings_.requests)},
                                   {"time", rough_time(findings_.duration)},
                                   {"absent", std::to_string(findings_.absent_hosts)}};
        talk(texts_("app.scan.summary", arguments) + '\n');
        if (findings_.absent_hosts > 0) talk(texts_("app.scan.absent", arguments) + '\n');
        if (!findings_.complete) talk(texts_("app.interrupted") + '\n');
    }

    ExitCode write_project() const {
        if (options_.project.empty()) return ExitCode::ok;
        if (findings_.devices.empty()) {
            talk(texts_("app.scan.no_project", {{"file", options_.project}}) + '\n');
            return ExitCode::ok;
        }
        const auto written =
            file::write_file(options_.project, scan_project(texts_, findings_), options_.force);
        if (written) {
            talk(texts_("app.scan.project_written", {{"file", options_.project}}) + '\n');
            return ExitCode::ok;
        }
        const auto& error = written.error();
        if (error.code == Code::cannot_open && error.numbers[0] == EEXIST)
            texts_.complain(texts_("app.convert.exists", {{"file", options_.project}}));
        else
            texts_.complain(texts_.describe(error));
        return ExitCode::partly;
    }

    [[nodiscard]] ExitCode code() const {
        if (interrupted_) return ExitCode::partly;
        // A bit rate that a port does not have is no failure.
        const auto error = std::ranges::find_if(findings_.troubles, [](const ScanTrouble& trouble) {
            return trouble.kind == ScanTrouble::Kind::error && trouble.error.code != Code::unsupported &&
                   trouble.error.code != Code::out_of_range;
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
    ScanFindings findings_;
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
