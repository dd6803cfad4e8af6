#include "listener.hpp"

#include <fmt/format.h>

#include <utility>

#include "takt/endpoint/serial_notices.hpp"
#include "takt/line/serial_port.hpp"
#include "takt/model/target_url.hpp"

namespace takt::endpoint {
namespace {

/// A session whose frames are damaged on their way out.
class FaultySession final : public line::Session {
public:
    FaultySession(std::unique_ptr<line::SlaveSession> session, wire::Framing framing,
                  sim::AnswerFaults& faults, sim::FaultSite site)
        : session_(std::move(session)), engine_(session_->engine(), framing, faults, std::move(site)) {}

    [[nodiscard]] Engine& engine() override { return engine_; }
    [[nodiscard]] std::size_t wants_bytes() const override { return session_->wants_bytes(); }
    [[nodiscard]] bool finished() const override { return session_->finished(); }
    [[nodiscard]] bool drained() const override { return session_->drained(); }
    [[nodiscard]] Instant last_received() const override { return session_->last_received(); }
    void attach(std::function<void()> poke) override { session_->attach(std::move(poke)); }

private:
    std::unique_ptr<line::SlaveSession> session_;
    sim::FaultyEngine engine_;
};

sim::FaultSite fault_site(const model::Line& line) {
    sim::FaultSite site{line.name, {}};
    for (const auto& device : line.devices) site.units.push_back(device.address);
    return site;
}

}  // namespace

Listener::Listener(const ListenerSpec& spec, const Environment& environment, serve::Responder& responder,
                   PendingAnswers& pending)
    : spec_(spec), environment_(environment), responder_(responder), pending_(pending) {
    if (environment.traffic) traffic_ = environment.traffic(spec.line);
    pending_.add(sessions_);
}

Listener::~Listener() {
    server_.reset();
    pending_.remove(sessions_);
    if (serial_answers_) pending_.remove(*serial_answers_);
}

Result<void> Listener::open() {
    return spec_.address ? open_tcp() : open_serial();
}

Result<void> Listener::open_tcp() {
    serve::TcpConfig config;
    config.framing = spec_.line.framing;
    config.frame_deadline = spec_.limits.frame_timeout;
    config.idle_deadline = spec_.limits.idle_timeout;
    const auto factory = [this, config](Instant, const line::Peer& peer) -> std::unique_ptr<line::Session> {
        serve::TcpConfig own = config;
        own.peer.assign(peer.address);
        own.role.assign(peer.role);
        auto session = std::make_unique<line::SlaveSession>(own, responder_, sessions_, traffic_.get());
        if (!environment_.faults) return session;
        return std::make_unique<FaultySession>(std::move(session), config.framing, *environment_.faults,
                                               fault_site(spec_.line));
    };
    line::TcpServerOptions limits;
    limits.max_connections = spec_.limits.max_connections;
    limits.max_per_peer = spec_.limits.max_per_peer;
    limits.write_limit = spec_.limits.write_timeout;
    limits.log = environment_.serve_log;
    if (spec_.line.transport == model::Transport::tls) {
        TAKT_TRY(limits.tls, tls::Context::load(tls::Side::server, spec_.line.tls));
    }
    TAKT_TRY(server_, line::TcpServer::listen(environment_.loop, *spec_.address, factory, limits));
    return {};
}

Result<void> Listener::open_serial() {
    serve::SerialConfig config;
    config.framing = spec_.line.framing;
    config.format = spec_.line.format;
    config.strict = spec_.strict;
    config.turnaround = spec_.turnaround;
    config.byte_timeout = spec_.byte_timeout;
    config.frame_timeout = spec_.frame_timeout;
    config.peer.assign(spec_.line.port);
    config.untimed = line::is_pseudo_terminal(spec_.line.port);
    slave_ = std::make_unique<serve::SerialSlave>(config, responder_, traffic_.get());
    Engine* engine = slave_.get();
    if (environment_.faults) {
        faulty_slave_ = std::make_unique<sim::FaultyEngine>(*slave_, config.framing, *environment_.faults,
                                                            fault_site(spec_.line));
        engine = faulty_slave_.get();
    }
    line::DriverOptions options;
    options.on_latency = [this](const line::SerialLatency& latency) {
        for (const auto& notice : latency_notices(spec_.line.port, latency)) environment_.notify(notice);
    };
    options.on_link = [this](Instant, bool up, const std::optional<Error>& why) { note_link(up, why); };
    TAKT_TRY(driver_, line::open_line(environment_.loop, spec_.line, *engine, options));
    serial_answers_ = std::make_unique<line::SerialAnswers>(*slave_, *driver_);
    pending_.add(*serial_answers_);
    return {};
}

// Attempts to open the port again repeat the reason; the loss is reported once.
void Listener::note_link(bool up, const std::optional<Error>& why) {
    if (up == std::exchange(port_open_, up)) return;
    if (up)
        environment_.notify(
            {Notice::Severity::status, "endpoint.port.open", {{"port", spec_.line.port}}, {}});
    else
        environment_.notify(
            {Notice::Severity::error, "endpoint.port.lost", {{"port", spec_.line.port}}, why});
}

std::string Listener::name() const {
    if (server_) return std::string(model::scheme_of(spec_.line)).append("://").append(server_->name());
    return fmt::format("{} {} {} bit/s", wire::name(spec_.line.framing), spec_.line.port,
                       spec_.line.format.baud);
}

ListenerStatistics Listener::statistics() const {
    ListenerStatistics statistics{name(), {}, {}};
    refresh(statistics);
    return statistics;
}

void Listener::refresh(ListenerStatistics& statistics) const {
    if (!server_) {
        if (slave_) statistics.counters = slave_->counters();
        return;
    }
    statistics.counters = sessions_.counters_now();
    statistics.connections = {.counters = server_->counters(),
                              .bad_headers = sessions_.closed(serve::CloseReason::bad_header),
                              .frame_deadlines = sessions_.closed(serve::CloseReason::frame_deadline),
                              .idle_deadlines = sessions_.closed(serve::CloseReason::idle_deadline)};
}

// Destroying the server ends its sessions, which then are counted.
ListenerStatistics Listener::close() {
    ListenerStatistics statistics = this->statistics();
    if (!server_) return statistics;
    server_.reset();
    statistics.counters = sessions_.counters();
    statistics.connections->bad_headers = sessions_.closed(serve::CloseReason::bad_header);
    statistics.connections->frame_deadlines = sessions_.closed(serve::CloseReason::frame_deadline);
    statistics.connections->idle_deadlines = sessions_.closed(serve::CloseReason::idle_deadline);
    return statistics;
}

}  // namespace takt::endpoint
