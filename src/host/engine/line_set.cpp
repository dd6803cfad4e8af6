#include "engine/line_set.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "takt/endpoint/serial_notices.hpp"

namespace takt::host {
namespace {

auto connection(const model::Line& line) {
    return std::tie(line.name, line.transport, line.port, line.tcp_port, line.tls, line.framing, line.rs485,
                    line.connection, line.format.baud, line.format.parity, line.format.stop_bits,
                    line.format.data_bits);
}

// The devices of a simulated line have exactly the registers of their variables.
bool same_registers(const model::Line& a, const model::Line& b) {
    const auto place = [](const model::Variable& v) { return std::tuple(v.area, v.start(), v.items()); };
    const auto same_device = [&](const model::Device& one, const model::Device& other) {
        return one.address == other.address &&
               std::ranges::equal(one.variables, other.variables, {}, place, place);
    };
    return std::ranges::equal(a.devices, b.devices, same_device);
}

}  // namespace

/// Between a driver and the engine of its line. Its index changes when another project is applied.
class LineSet::Forwarder final : public Engine {
public:
    Forwarder(LineSet& set, std::size_t line) : set_(set), line_(line) {}

    [[nodiscard]] std::size_t line() const { return line_; }
    void set_line(std::size_t line) { line_ = line; }

    /// While the connection is open, and after its end.
    [[nodiscard]] Instant opened_at() const { return opened_at_; }
    /// @returns whether it is the first call
    [[nodiscard]] bool report_once() { return !std::exchange(reported_, true); }

    void on_link(Instant t, bool up) override {
        if (up) opened_at_ = t;
        engine().on_link(t, up);
        set_.on_event_(t, line_);
    }
    void on_close(Instant t) override {
        engine().on_close(t);
        set_.on_event_(t, line_);
    }
    std::optional<Instant> opens_at() const override { return engine().opens_at(); }
    std::optional<Error> rejection() const override { return engine().rejection(); }
    void on_bytes(Instant t, Bytes bytes) override {
        engine().on_bytes(t, bytes);
        set_.on_event_(t, line_);
    }
    void on_tick(Instant t) override {
        engine().on_tick(t);
        set_.on_event_(t, line_);
    }
    Bytes transmit(Instant t) override { return engine().transmit(t); }
    Instant next_wakeup() const override { return engine().next_wakeup(); }

private:
    [[nodiscard]] Engine& engine() const { return set_.engine_->master().line(line_); }

    LineSet& set_;
    std::size_t line_;
    Instant opened_at_{};
    bool reported_ = false;
};

LineSet::LineSet(HostLink& link, line::Loop& loop, std::function<void(std::size_t, sim::Devices&)> prepare,
                 endpoint::NoticeSink notify, OnLineEvent on_event)
    : link_(link),
      loop_(loop),
      prepare_(std::move(prepare)),
      notify_(std::move(notify)),
      on_event_(std::move(on_event)),
      gate_(loop),
      connection_limit_([this](const std::string& host) { make_room(host); }) {}

LineSet::~LineSet() = default;

std::vector<std::shared_ptr<TrafficPublisher>> LineSet::traffic_of(const Configuration& next) const {
    std::vector<std::shared_ptr<TrafficPublisher>> traffic;
    for (std::size_t i = 0; i < next.project().lines.size(); ++i) {
        const auto before = continued(next, i);
        traffic.push_back(
            before ? lines_[*before].traffic
                   : std::make_shared<TrafficPublisher>(link_, TrafficSource{.index = i}, next.generation()));
    }
    return traffic;
}

std::optional<std::size_t> LineSet::continued(const Configuration& next, std::size_t index) const {
    if (!engine_) return std::nullopt;
    const auto& line = next.project().lines[index];
    const auto& running = engine_->configuration()->project().lines;
    const auto found = std::ranges::find(running, line.name, &model::Line::name);
    if (found == running.end() || connection(*found) != connection(line)) return std::nullopt;
    if (line.transport == model::Transport::simulated && !same_registers(*found, line)) return std::nullopt;
    return static_cast<std::size_t>(found - running.begin());
}

Result<void> LineSet::open(ProjectEngine& engine, std::vector<std::shared_ptr<TrafficPublisher>> traffic) {
    engine_ = &engine;
    lines_.resize(traffic.size());
    // A port that is missing must not end a run that has other lines to poll.
    for (std::size_t i = 0; i < lines_.size(); ++i) {
        lines_[i].traffic = std::move(traffic[i]);
        TAKT_CHECK(open_line(i, lines_.size() > 1));
    }
    return {};
}

void LineSet::move_to(ProjectEngine& engine, std::vector<std::shared_ptr<TrafficPublisher>> traffic) {
    const auto& next = *engine.configuration();
    std::vector<std::optional<std::size_t>> before;
    for (std::size_t i = 0; i < traffic.size(); ++i) before.push_back(continued(next, i));
    auto old = std::exchange(lines_, std::vector<Line>(traffic.size()));
    engine_ = &engine;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
        if (before[i]) lines_[i] = std::move(old[*before[i]]);
        lines_[i].traffic = std::move(traffic[i]);
        lines_[i].traffic->set_source(TrafficSource{.index = i}, next.generation());
        if (before[i]) lines_[i].forwarder->set_line(i);
    }
    old.clear();  // closes the others, so that a port is free for a new line
    constexpr bool kWaitForPort = true;
    for (std::size_t i = 0; i < lines_.size(); ++i) {
        if (lines_[i].driver) continue;
        if (const auto opened = open_line(i, kWaitForPort); !opened)
            engine.on_link(line::now(), i, false, opened.error());
    }
}

// Another line waits for a connection to that host: those between two requests close theirs.
void LineSet::make_room(const std::string& host) {
    loop_.post([this, host] {
        for (auto& line : lines_)
            if (line.driver && connection_limit_.wanted(host)) line.driver->poke();
    });
}

Result<void> LineSet::open_line(std::size_t index, bool wait_for_port) {
    const auto& settings = engine_->configuration()->project().lines[index];
    Line& line = lines_[index];
    line.forwarder = std::make_unique<Forwarder>(*this, index);
    line::DriverOptions options;
    options.gate = &gate_;
    options.on_link = [this, forwarder = line.forwarder.get()](Instant t, bool up,
                                                               const std::optional<Error>& why) {
        engine_->on_link(t, forwarder->line(), up, why);
        on_event_(t, forwarder->line());
    };
    options.on_close = [this, forwarder = line.forwarder.get()](Instant t, const std::optional<Error>& why) {
        const std::size_t closed = forwarder->line();
        engine_->on_close(t, closed, why);
        const auto& rules = engine_->configuration()->project().lines[closed].connection;
        const Duration open_for = t - forwarder->opened_at();
        if (why && why->code == Code::connection_lost && open_for < rules.pause_after &&
            forwarder->report_once())
            engine_->on_closed_in_pause(closed, open_for);
    };
    options.on_latency = [this, port = settings.port](const line::SerialLatency& latency) {
        for (const auto& notice : endpoint::latency_notices(port, latency)) notify_(notice);
    };
    options.wait_for_port = wait_for_port;
    options.must_reconnect = [this, forwarder = line.forwarder.get(), host = settings.port] {
        const auto& poller = engine_->master().line(forwarder->line());
        return poller.must_reconnect() || (connection_limit_.wanted(host) && poller.idle());
    };
    if (settings.connection.per_host) {
        options.connection_limit = &connection_limit_;
        options.connections_per_host = *settings.connection.per_host;
    }
    if (settings.transport != model::Transport::simulated) {
        TAKT_TRY(line.driver, line::open_line(loop_, settings, *line.forwarder, options));
        return {};
    }
    line.simulated = std::make_unique<sim::SimulatedLine>(settings, *line.forwarder);
    if (prepare_) prepare_(index, line.simulated->devices());
    line.driver = line::run_simulated(loop_, *line.simulated, settings.name, options);
    return {};
}

}  // namespace takt::host
