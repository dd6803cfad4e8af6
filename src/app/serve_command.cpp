// Being the devices of a project on its lines, or one blank device.
#include <fmt/format.h>

#include <memory>
#include <vector>

#include "takt/app/commands.hpp"
#include "takt/app/project.hpp"
#include "takt/app/stop_signals.hpp"
#include "takt/app/texts.hpp"
#include "takt/app/traffic_log.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/loop.hpp"
#include "takt/line/serial_port.hpp"
#include "takt/line/slave_session.hpp"
#include "takt/line/tcp_server.hpp"
#include "takt/serve/serial_slave.hpp"
#include "takt/sim/devices.hpp"

namespace takt::app {
namespace {

/// Where the devices of a line are to be found, and what they are.
struct Place {
    model::Line line;  ///< with the transport, port and format in force
    std::optional<line::ListenAddress> listen;
    std::shared_ptr<sim::Devices> devices;  ///< shared by the places of one blank device
};

/// A target, or just the device file of a serial port.
Result<model::Line> serial_line(const std::string& port, const model::Line& otherwise) {
    if (port.find("://") == std::string::npos) {
        model::Line line = otherwise;
        line.transport = model::Transport::serial;
        line.port = port;
        return line;
    }
    TAKT_TRY(const auto target, line::parse_target(port));
    if (target.transport != model::Transport::serial) return fail(Code::unsupported, port);
    model::Line line = target.as_line();
    line.name = otherwise.name;
    line.devices = otherwise.devices;
    return line;
}

/// Listens where the text says; RTU over TCP where the line's own framing is RTU on a TCP line.
Result<Place> listening(const std::string& address, model::Line line, std::shared_ptr<sim::Devices> devices) {
    TAKT_TRY(const auto listen, line::parse_listen(address));
    if (line.is_serial()) line.framing = wire::Framing::tcp;
    line.transport = model::Transport::tcp;
    line.port = address;
    return Place{std::move(line), listen, std::move(devices)};
}

Result<std::vector<Place>> blank_places(const ServeOptions& options) {
    const auto devices = std::make_shared<sim::Devices>(UnitId{options.unit}, options.fill);
    model::Line line;
    line.name = "takt";
    std::vector<Place> places;
    if (!options.listen.empty()) {
        TAKT_TRY(auto place, listening(options.listen, line, devices));
        places.push_back(std::move(place));
    }
    if (!options.port.empty()) {
        TAKT_TRY(auto serial, serial_line(options.port, line));
        places.push_back({std::move(serial), std::nullopt, devices});
    }
    return places;
}

Result<Place> own_place(const model::Line& line, std::shared_ptr<sim::Devices> devices) {
    switch (line.transport) {
        case model::Transport::serial: return Place{line, std::nullopt, std::move(devices)};
        case model::Transport::tcp:
            return Place{line, line::ListenAddress{line.port, line.tcp_port}, std::move(devices)};
        case model::Transport::tls:
        case model::Transport::simulated: break;
    }
    return fail(Code::unsupported, line.name + ": " + std::string(model::name(line.transport)));
}

Result<std::vector<Place>> project_places(const model::Project& project, const ServeOptions& options) {
    sim::Devices::Options moving;
    moving.prompt = true;
    std::vector<Place> places;
    for (const auto& line : project.lines) {
        auto devices = std::make_shared<sim::Devices>(line, moving);
        Result<Place> place = fail(Code::unsupported, line.name);
        if (!options.listen.empty()) {
            place = listening(options.listen, line, std::move(devices));
        } else if (!options.port.empty()) {
            TAKT_TRY(auto serial, serial_line(options.port, line));
            place = Place{std::move(serial), std::nullopt, std::move(devices)};
        } else {
            place = own_place(line, std::move(devices));
        }
        if (!place) return std::unexpected(place.error());
        places.push_back(*std::move(place));
    }
    return places;
}

/// One place at work.
struct Serving {
    std::unique_ptr<LineTraffic> traffic;
    std::unique_ptr<serve::SerialSlave> slave;
    std::unique_ptr<line::Driver> driver;
    std::unique_ptr<line::TcpServer> server;
};

Result<Serving> start(line::Loop& loop, const Place& place, TrafficLog* log) {
    Serving serving;
    if (log) serving.traffic = std::make_unique<LineTraffic>(*log, place.line, LineTraffic::Side::slave);
    wire::TrafficObserver* traffic = serving.traffic.get();
    if (place.listen) {
        const auto factory = [framing = place.line.framing, devices = place.devices, traffic](
                                 Instant, std::string_view peer) {
            serve::TcpConfig config;
            config.framing = framing;
            config.peer.assign(peer);
            return std::make_unique<line::SlaveSession>(config, *devices, traffic);
        };
        TAKT_TRY(serving.server, line::TcpServer::listen(loop, *place.listen, factory));
        return serving;
    }
    serve::SerialConfig config;
    config.framing = place.line.framing;
    config.format = place.line.format;
    config.peer.assign(place.line.port);
    config.untimed = line::is_pseudo_terminal(place.line.port);
    serving.slave = std::make_unique<serve::SerialSlave>(config, *place.devices, traffic);
    TAKT_TRY(serving.driver, line::open_line(loop, place.line, *serving.slave));
    return serving;
}

std::string place_text(const Texts& texts, const Place& place, const Serving& serving) {
    std::string units;
    for (std::size_t i = 0; i < place.devices->size(); ++i)
        units += (i == 0 ? "" : ", ") + std::to_string((*place.devices)[i].address().value);
    const std::string where =
        serving.server ? std::string(place.line.framing == wire::Framing::tcp ? "tcp://" : "rtu+tcp://") +
                             serving.server->name()
                       : fmt::format("{} {} {} bit/s", wire::name(place.line.framing), place.line.port,
                                     place.line.format.baud);
    return texts("app.serving", {{"where", where}, {"units", units}}) + '\n';
}

Result<void> serve_places(const Texts& texts, const std::vector<Place>& places, const ServeOptions& options) {
    TAKT_TRY(const auto loop, line::Loop::create());
    TAKT_CHECK(on_stop(*loop, [&] { loop->stop(); }));
    std::unique_ptr<TrafficLog> log;
    if (!options.traffic.empty()) {
        TAKT_TRY(log, TrafficLog::open(options.traffic));
    }
    std::vector<Serving> all;
    for (const auto& place : places) {
        TAKT_TRY(auto serving, start(*loop, place, log.get()));
        talk(place_text(texts, place, serving));
        all.push_back(std::move(serving));
    }
    if (options.run_for)
        loop->run_until([] { return false; }, *options.run_for);
    else
        loop->run();
    return {};
}

ExitCode ended(const Texts& texts, const Result<void>& result) {
    if (result) return ExitCode::ok;
    texts.complain(texts.describe(result.error()));
    return exit_code(result.error());
}

}  // namespace

ExitCode serve(const CommonOptions& common, const ServeOptions& options) {
    const Texts texts(common.language);
    std::optional<LoadedProject> loaded;
    if (options.file.empty()) {
        if (options.listen.empty() && options.port.empty()) {
            texts.complain(texts("app.serve_where"));
            return ExitCode::usage;
        }
    } else {
        loaded = load_to_run(texts, options.file);
        if (!loaded) return ExitCode::usage;
        const bool replaced = !options.listen.empty() || !options.port.empty();
        if (replaced &&
            (loaded->project.lines.size() != 1 || (!options.listen.empty() && !options.port.empty()))) {
            texts.complain(
                texts("app.serve_one_line", {{"count", std::to_string(loaded->project.lines.size())}}));
            return ExitCode::usage;
        }
    }
    const auto places = loaded ? project_places(loaded->project, options) : blank_places(options);
    if (!places) return ended(texts, std::unexpected(places.error()));
    return ended(texts, serve_places(texts, *places, options));
}

}  // namespace takt::app
