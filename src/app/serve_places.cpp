#include "serve_places.hpp"

#include <algorithm>
#include <filesystem>
#include <span>

#include "blank_device.hpp"
#include "served_server.hpp"
#include "takt/sim/devices.hpp"

namespace takt::app {
namespace {

std::vector<UnitId> units_of(const sim::Devices& devices) {
    std::vector<UnitId> units;
    for (std::size_t i = 0; i < devices.size(); ++i) units.push_back(devices[i].address());
    return units;
}

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
    auto units = units_of(*devices);
    return Place{.line = std::move(line),
                 .listen = listen,
                 .responder = std::move(devices),
                 .units = std::move(units)};
}

void put_options(Place& place, const ServeOptions& options) {
    place.strict = options.strict;
    place.limits = options.limits.instead_of({});
}

bool guarded(const ServeOptions& options) {
    return !options.access.empty() || !options.audit.empty();
}

/// Puts rules and a log, of which there are none yet, before the responder of the place.
void guard(Place& place, std::span<serve::Unit> units) {
    place.guard = std::make_shared<GuardedServer>(place.responder, place.units);
    for (auto& unit : units) place.guard->watch(unit);
    place.answers->watch([guard = std::weak_ptr(place.guard)](serve::Token token, Bytes pdu) {
        if (const auto there = guard.lock()) there->answered(token, pdu);
    });
    place.responder = place.guard;
}

std::string audit_path(const std::string& project_file, const model::Server& server) {
    if (server.audit.empty()) return {};
    return (std::filesystem::path(project_file).parent_path() / server.audit).string();
}

store::Durability durability_of(model::Durability durability) {
    switch (durability) {
        case model::Durability::acknowledged: break;
        case model::Durability::interval: return store::Durability::interval;
        case model::Durability::at_end: return store::Durability::at_end;
    }
    return store::Durability::acknowledged;
}

/// Beside the project: PLANT.SERVER-1.registers for PLANT.yaml.
std::string state_path(const std::string& project_file, const model::Server& server,
                       const model::ServerUnit& unit) {
    const std::filesystem::path project(project_file);
    if (!unit.state.empty()) return (project.parent_path() / unit.state).string();
    std::string name = server.name;
    std::ranges::replace(name, '/', '_');
    return std::filesystem::path(project)
        .replace_extension("." + name + "-" + std::to_string(unit.address.value) + ".registers")
        .string();
}

std::shared_ptr<RetainedServer> retained_server(const std::shared_ptr<ServedServer>& served,
                                                const model::Server& server,
                                                const std::string& project_file) {
    std::shared_ptr<RetainedServer> retained;
    for (std::size_t i = 0; i < server.units.size(); ++i) {
        const model::ServerUnit& unit = server.units[i];
        RetainPlan plan{{}, durability_of(unit.durability), state_path(project_file, server, unit)};
        bool any = false;
        for (std::size_t area = 0; area < plan.items.size(); ++area) {
            for (const auto [first, last] : unit.retained[area]) plan.items[area].push_back({first, last});
            any = any || !plan.items[area].empty();
        }
        if (!any) continue;
        if (!retained) retained = std::make_shared<RetainedServer>(served);
        retained->add(served->units()[i], std::move(plan));
    }
    return retained;
}

Result<Place> own_place(const model::Line& line, std::shared_ptr<sim::Devices> devices) {
    switch (line.transport) {
        case model::Transport::serial:
            return Place{.line = line, .responder = devices, .units = units_of(*devices)};
        case model::Transport::tcp:
            return Place{.line = line,
                         .listen = line::ListenAddress{line.port, line.tcp_port},
                         .responder = devices,
                         .units = units_of(*devices)};
        case model::Transport::tls:
        case model::Transport::simulated: break;
    }
    return fail(Code::unsupported, line.name + ": " + std::string(model::name(line.transport)));
}

}  // namespace

model::ListenLimits ServeLimits::instead_of(const model::ListenLimits& limits) const {
    return {max_connections.value_or(limits.max_connections), max_per_peer.value_or(limits.max_per_peer),
            frame_timeout.value_or(limits.frame_timeout), idle_timeout.value_or(limits.idle_timeout),
            write_timeout.value_or(limits.write_timeout)};
}

Result<std::vector<Place>> blank_places(const ServeOptions& options) {
    const auto blank = std::make_shared<BlankDevice>(options);
    const std::shared_ptr<sim::Devices> devices(blank, &blank->devices());
    model::Line line;
    line.name = "takt";
    std::vector<Place> places;
    if (!options.listen.empty()) {
        TAKT_TRY(auto place, listening(options.listen, line, devices));
        places.push_back(std::move(place));
    }
    if (!options.port.empty()) {
        TAKT_TRY(auto serial, serial_line(options.port, line));
        places.push_back({.line = std::move(serial), .responder = devices, .units = units_of(*devices)});
    }
    for (auto& place : places) {
        put_options(place, options);
        place.answers = places.front().answers;
    }
    if (!options.state.empty() && !places.empty()) {
        const auto retained = std::make_shared<RetainedServer>(devices);
        retained->add(blank->unit(), {blank->retained(), durability_of(options.durability), options.state});
        places.front().retained = retained;
        for (auto& place : places) place.responder = retained;
    }
    if (guarded(options) && !places.empty()) {
        guard(places.front(), {&blank->unit(), 1});
        for (auto& place : places) {
            place.responder = places.front().responder;
            place.guard = places.front().guard;
            place.audit = options.audit;
        }
    }
    return places;
}

Result<std::vector<Place>> device_places(const model::Project& project, const ServeOptions& options) {
    sim::Devices::Options moving;
    moving.prompt = true;
    std::vector<Place> places;
    for (const auto& line : project.lines) {
        const auto devices = std::make_shared<sim::Devices>(line, moving);
        Result<Place> place = fail(Code::unsupported, line.name);
        if (!options.listen.empty()) {
            place = listening(options.listen, line, devices);
        } else if (!options.port.empty()) {
            TAKT_TRY(auto serial, serial_line(options.port, line));
            place = Place{.line = std::move(serial), .responder = devices, .units = units_of(*devices)};
        } else {
            place = own_place(line, devices);
        }
        if (!place) return std::unexpected(place.error());
        put_options(*place, options);
        if (guarded(options)) {
            guard(*place, devices->units());
            place->audit = options.audit;
        }
        places.push_back(*std::move(place));
    }
    return places;
}

std::vector<Place> server_places(const model::Project& project, const ServeOptions& options,
                                 const Around& around) {
    std::vector<Place> places;
    for (const auto& server : project.servers) {
        Place place;
        place.line.name = server.name;
        place.line.transport = server.transport;
        place.line.port = server.port;
        place.line.tcp_port = server.tcp_port;
        place.line.framing = server.framing;
        place.line.format = server.format;
        place.line.rs485 = server.rs485;
        if (server.transport == model::Transport::tcp)
            place.listen = line::ListenAddress{server.port == "*" ? "" : server.port, server.tcp_port};
        const auto served = std::make_shared<ServedServer>(server);
        place.served = served;
        place.responder = served;
        place.retained = retained_server(served, server, options.file);
        if (place.retained) place.responder = place.retained;
        for (const auto& unit : server.units) place.units.push_back(unit.address);
        if (around) around(places.size(), place);
        guard(place, served->units());
        place.access = server.access;
        place.audit = options.audit.empty() ? audit_path(options.file, server) : options.audit;
        place.strict = server.strict || options.strict;
        place.turnaround = server.turnaround;
        place.limits = options.limits.instead_of(server.limits);
        places.push_back(std::move(place));
    }
    return places;
}

Result<void> open_retained(line::Loop& loop, const Texts& texts, const Place& place) {
    if (!place.retained) return {};
    serve::AnswerSink& way = place.retained_answers ? *place.retained_answers : *place.answers;
    return place.retained->open(loop, texts, way, place.answers->tokens());
}

}  // namespace takt::app
