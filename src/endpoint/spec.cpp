#include "takt/endpoint/spec.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "takt/model/service.hpp"

namespace takt::endpoint {
namespace {

namespace fs = std::filesystem;

/// A target, or just the device file of a serial port.
Result<ListenerSpec> serial_listener(const std::string& port, const model::Line& otherwise) {
    ListenerSpec listener{.line = otherwise};
    listener.line.transport = model::Transport::serial;
    listener.line.port = port;
    if (port.find("://") == std::string::npos) return listener;
    TAKT_TRY(const auto target, line::parse_target(port));
    if (target.transport != model::Transport::serial) return fail(Code::unsupported, port);
    listener.line = target.as_line();
    listener.line.name = otherwise.name;
    listener.line.devices = otherwise.devices;
    return listener;
}

/// RTU over TCP where the line's own framing is RTU on a TCP line, else Modbus TCP.
Result<ListenerSpec> tcp_listener(const std::string& address, model::Line line) {
    TAKT_TRY(const auto listen, line::parse_listen(address));
    if (line.is_serial()) line.framing = wire::Framing::tcp;
    line.transport = listen.certificates ? model::Transport::tls : model::Transport::tcp;
    if (listen.certificates) line.tls = model::files_in(*listen.certificates, "server");
    line.port = address;
    return ListenerSpec{.line = std::move(line), .address = listen};
}

/// Where a project's line itself is.
Result<ListenerSpec> own_listener(const model::Line& line) {
    switch (line.transport) {
        case model::Transport::serial: return ListenerSpec{.line = line};
        case model::Transport::tcp:
            return ListenerSpec{.line = line, .address = line::ListenAddress{line.port, line.tcp_port}};
        case model::Transport::tls:
        case model::Transport::simulated: break;
    }
    return fail(Code::unsupported, line.name + ": " + std::string(model::name(line.transport)));
}

ListenerSpec server_listener(const model::Server& server) {
    ListenerSpec listener;
    listener.line.name = server.name;
    listener.line.transport = server.transport;
    listener.line.port = server.port;
    listener.line.tcp_port = server.tcp_port;
    listener.line.framing = server.framing;
    listener.line.format = server.format;
    listener.line.rs485 = server.rs485;
    listener.line.tls = server.tls;
    if (model::is_network(server.transport))
        listener.address = line::ListenAddress{server.port == "*" ? "" : server.port, server.tcp_port};
    listener.strict = server.strict;
    listener.turnaround = server.turnaround;
    listener.byte_timeout = server.byte_timeout.value_or(Duration::zero());
    listener.frame_timeout = server.frame_timeout.value_or(Duration::zero());
    listener.limits = server.limits;
    return listener;
}

void apply(const Overrides& overrides, EndpointSpec& spec) {
    for (auto& listener : spec.listeners) {
        listener.strict = listener.strict || overrides.strict;
        listener.byte_timeout = overrides.limits.byte_timeout.value_or(listener.byte_timeout);
        listener.frame_timeout = overrides.limits.frame_timeout.value_or(listener.frame_timeout);
        listener.limits = overrides.limits.instead_of(listener.limits);
    }
    if (overrides.access) spec.access = *overrides.access;
    spec.access_is_override = overrides.access.has_value();
    if (!overrides.audit.empty()) spec.audit = overrides.audit;
}

/// Beside the project: PLANT.SERVER-1.registers for PLANT.yaml.
std::string state_path(const fs::path& project, const model::Server& server, const model::ServerUnit& unit) {
    if (!unit.state.empty()) return (project.parent_path() / unit.state).string();
    std::string name = server.name;
    std::ranges::replace(name, '/', '_');
    return fs::path(project)
        .replace_extension("." + name + "-" + std::to_string(unit.address.value) + ".registers")
        .string();
}

store::Durability to_durability(model::Durability durability) {
    switch (durability) {
        case model::Durability::acknowledged: break;
        case model::Durability::interval: return store::Durability::interval;
        case model::Durability::at_end: return store::Durability::at_end;
    }
    return store::Durability::acknowledged;
}

std::vector<RetainSpec> retained_of(const model::Server& server, const fs::path& project) {
    std::vector<RetainSpec> all;
    for (std::size_t i = 0; i < server.units.size(); ++i) {
        const model::ServerUnit& unit = server.units[i];
        RetainSpec retained{i, {}, to_durability(unit.durability), state_path(project, server, unit)};
        for (std::size_t area = 0; area < retained.items.size(); ++area)
            for (const auto [first, last] : unit.retained[area])
                retained.items[area].push_back({first, last});
        if (!std::ranges::all_of(retained.items, [](const auto& items) { return items.empty(); }))
            all.push_back(std::move(retained));
    }
    return all;
}

/// All four areas, and an identification.
model::ServerUnit blank_unit(UnitId address) {
    model::ServerUnit unit{.address = address,
                           .identification = {{0, "Takt"}, {1, "takt serve"}, {2, "1"}},
                           .server_id = "takt"};
    for (auto& items : unit.offered) items = {{0, 65535}};
    return unit;
}

bool is_of_line(const model::Binding& binding) {
    const auto* const local = binding.source ? std::get_if<model::LocalSource>(&*binding.source) : nullptr;
    if (local && model::is_service_name(local->name)) return true;
    const bool read = binding.source && std::holds_alternative<model::VariableSource>(*binding.source);
    return read || (binding.sink && std::holds_alternative<model::VariableSource>(*binding.sink));
}

}  // namespace

model::ListenLimits LimitOverrides::instead_of(const model::ListenLimits& limits) const {
    return {max_connections.value_or(limits.max_connections), max_per_peer.value_or(limits.max_per_peer),
            frame_timeout.value_or(limits.frame_timeout), idle_timeout.value_or(limits.idle_timeout),
            write_timeout.value_or(limits.write_timeout)};
}

std::vector<EndpointSpec> server_endpoints(const model::Project& project, const std::string& project_file,
                                           const Overrides& overrides, bool relays) {
    const fs::path file(project_file);
    std::vector<EndpointSpec> specs;
    for (const auto& server : project.servers) {
        EndpointSpec spec;
        spec.name = server.name;
        spec.listeners.push_back(server_listener(server));
        spec.units = ServerUnits{server.units, overrides.fill};
        spec.retained = retained_of(server, file);
        spec.access = server.access;
        if (!server.audit.empty()) spec.audit = (file.parent_path() / server.audit).string();
        if (relays) spec.relays = server.relays;
        apply(overrides, spec);
        specs.push_back(std::move(spec));
    }
    return specs;
}

Result<std::vector<EndpointSpec>> device_endpoints(const model::Project& project,
                                                   const Overrides& overrides) {
    std::vector<EndpointSpec> specs;
    for (const auto& line : project.lines) {
        TAKT_TRY(auto listener, !overrides.listen.empty() ? tcp_listener(overrides.listen, line)
                                : !overrides.port.empty() ? serial_listener(overrides.port, line)
                                                          : own_listener(line));
        EndpointSpec spec;
        spec.name = line.name;
        spec.listeners.push_back(std::move(listener));
        spec.units = LineDevices{line};
        apply(overrides, spec);
        specs.push_back(std::move(spec));
    }
    return specs;
}

Result<EndpointSpec> blank_endpoint(UnitId unit, const Overrides& overrides) {
    EndpointSpec spec;
    spec.name = "takt";
    model::Line line;
    line.name = spec.name;
    if (!overrides.listen.empty()) {
        TAKT_TRY(auto listener, tcp_listener(overrides.listen, line));
        spec.listeners.push_back(std::move(listener));
    }
    if (!overrides.port.empty()) {
        TAKT_TRY(auto listener, serial_listener(overrides.port, line));
        spec.listeners.push_back(std::move(listener));
    }
    spec.units = ServerUnits{{blank_unit(unit)}, overrides.fill};
    apply(overrides, spec);
    return spec;
}

std::size_t bound_to_lines(const model::Project& project) {
    std::size_t count = 0;
    for (const auto& server : project.servers)
        for (const auto& unit : server.units)
            count += static_cast<std::size_t>(std::ranges::count_if(unit.bindings, is_of_line));
    return count;
}

}  // namespace takt::endpoint
