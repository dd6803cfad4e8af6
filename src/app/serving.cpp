#include "serving.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "takt/app/log.hpp"
#include "takt/line/serial_port.hpp"

namespace takt::app {
namespace {

/// A session whose answers are damaged.
class FaultySession final : public line::Session {
public:
    FaultySession(std::unique_ptr<line::SlaveSession> session, wire::Framing framing,
                  sim::AnswerFaults& faults)
        : session_(std::move(session)), engine_(session_->engine(), framing, faults) {}

    [[nodiscard]] Engine& engine() override { return engine_; }
    [[nodiscard]] std::size_t wants_bytes() const override { return session_->wants_bytes(); }
    [[nodiscard]] bool finished() const override { return session_->finished(); }
    void attach(std::function<void()> poke) override { session_->attach(std::move(poke)); }

private:
    std::unique_ptr<line::SlaveSession> session_;
    sim::FaultyEngine engine_;
};

/// Who answers at a place: its responder, or what is to make it misbehave.
serve::Responder& responder_of(const Place& place, Serving& serving) {
    if (!place.faults) return *place.responder;
    serving.faulty = std::make_unique<sim::FaultyResponder>(*place.responder, *place.faults);
    return *serving.faulty;
}

Result<std::unique_ptr<line::TcpServer>> listen(line::Loop& loop, const Place& place, Serving& serving) {
    serving.sessions = std::make_unique<line::SlaveSessions>();
    place.answers->add(*serving.sessions);
    serve::TcpConfig config;
    config.framing = place.line.framing;
    config.frame_deadline = place.limits.frame_timeout;
    config.idle_deadline = place.limits.idle_timeout;
    const auto factory = [config, responder = &responder_of(place, serving), faults = place.faults,
                          traffic = serving.traffic.get(), sessions = serving.sessions.get()](
                             Instant, std::string_view peer) -> std::unique_ptr<line::Session> {
        serve::TcpConfig own = config;
        own.peer.assign(peer);
        auto session = std::make_unique<line::SlaveSession>(own, *responder, *sessions, traffic);
        if (!faults) return session;
        return std::make_unique<FaultySession>(std::move(session), config.framing, *faults);
    };
    line::TcpServerOptions limits;
    limits.max_connections = place.limits.max_connections;
    limits.max_per_peer = place.limits.max_per_peer;
    limits.write_limit = place.limits.write_timeout;
    limits.log = app::log("serve");
    return line::TcpServer::listen(loop, *place.listen, factory, limits);
}

/// "1, 2, 5..20": ascending ones beside each other together.
std::string units_text(std::vector<UnitId> units) {
    constexpr std::size_t kFew = 3;
    std::ranges::sort(units);
    std::string text;
    for (std::size_t i = 0; i < units.size();) {
        std::size_t run = 1;
        while (i + run < units.size() && units[i + run].value == units[i].value + run) ++run;
        if (run <= kFew) run = 1;
        text += (text.empty() ? "" : ", ") + std::to_string(units[i].value);
        if (run > 1) text += ".." + std::to_string(units[i + run - 1].value);
        i += run;
    }
    return text;
}

report::EndpointSummary close_place(const Place& place, Serving& serving) {
    report::EndpointSummary served{place_name(place, serving), {}, {}};
    if (!serving.server) {
        served.counters = serving.slave->counters();
        return served;
    }
    const auto connections = serving.server->counters();
    serving.server.reset();
    served.counters = serving.sessions->counters();
    served.connections = {.accepted = connections.accepted,
                          .refused = connections.refused,
                          .over_limit = connections.over_limit,
                          .over_peer_limit = connections.over_peer_limit,
                          .no_descriptors = connections.no_descriptors,
                          .bad_headers = serving.sessions->closed(serve::CloseReason::bad_header),
                          .frame_deadlines = serving.sessions->closed(serve::CloseReason::frame_deadline),
                          .idle_deadlines = serving.sessions->closed(serve::CloseReason::idle_deadline),
                          .write_stalls = connections.write_stalls};
    return served;
}

}  // namespace

Result<Serving> start_serving(line::Loop& loop, const Place& place, TrafficLog* log) {
    Serving serving;
    if (log) serving.traffic = std::make_unique<LineTraffic>(*log, place.line, LineTraffic::Side::slave);
    wire::TrafficObserver* traffic = serving.traffic.get();
    if (place.listen) {
        TAKT_TRY(serving.server, listen(loop, place, serving));
        return serving;
    }
    serve::SerialConfig config;
    config.framing = place.line.framing;
    config.format = place.line.format;
    config.strict = place.strict;
    config.turnaround = place.turnaround;
    config.peer.assign(place.line.port);
    config.untimed = line::is_pseudo_terminal(place.line.port);
    serving.slave = std::make_unique<serve::SerialSlave>(config, responder_of(place, serving), traffic);
    Engine* engine = serving.slave.get();
    if (place.faults) {
        serving.faulty_slave =
            std::make_unique<sim::FaultyEngine>(*serving.slave, config.framing, *place.faults);
        engine = serving.faulty_slave.get();
    }
    TAKT_TRY(serving.driver, line::open_line(loop, place.line, *engine));
    serving.serial_answers = std::make_unique<line::SerialAnswers>(*serving.slave, *serving.driver);
    place.answers->add(*serving.serial_answers);
    return serving;
}

std::string place_name(const Place& place, const Serving& serving) {
    if (serving.server)
        return std::string(place.line.framing == wire::Framing::tcp ? "tcp://" : "rtu+tcp://") +
               serving.server->name();
    return fmt::format("{} {} {} bit/s", wire::name(place.line.framing), place.line.port,
                       place.line.format.baud);
}

std::string place_text(const Texts& texts, const Place& place, const Serving& serving) {
    return texts("app.serving", {{"where", place_name(place, serving)}, {"units", units_text(place.units)}}) +
           '\n';
}

report::ServeSummary end_serving(const std::vector<Place>& places, std::vector<Serving>& serving) {
    report::ServeSummary summary;
    for (const auto& place : places) {
        if (!place.retained) continue;
        place.retained->finish();
        std::ranges::move(place.retained->summary(), std::back_inserter(summary.retained));
    }
    for (std::size_t i = 0; i < serving.size(); ++i)
        summary.endpoints.push_back(close_place(places[i], serving[i]));
    return summary;
}

}  // namespace takt::app
