#include <algorithm>
#include <bitset>
#include <span>
#include <vector>

#include "servers/interpretation.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::model {
namespace {

constexpr std::string_view kServerSerialKeys[] = {"port",  "baud",   "parity",     "stop_bits",   "data_bits",
                                                  "rs485", "strict", "turnaround", "byte_timeout"};
constexpr std::string_view kListenerKeys[] = {"listen",       "tcp_port",     "max_connections",
                                              "max_per_peer", "idle_timeout", "write_timeout"};

/// Whether two listeners accept the same connections.
bool collide(const Interpretation::Listener& a, const Interpretation::Listener& b) {
    if (a.tcp_port != b.tcp_port) return false;
    const auto takes_all_of = [](const Interpretation::Listener& one, const Interpretation::Listener& other) {
        if (!one.address) return true;
        const bool any = *one.address == *parse_ip("0.0.0.0") || *one.address == *parse_ip("::");
        return any && other.address && one.address->is_ipv4() == other.address->is_ipv4();
    };
    return takes_all_of(a, b) || takes_all_of(b, a) || a.address == b.address;
}

void note_listener(Interpretation& state, Reader& reader, const Server& server) {
    const auto address = parse_ip(server.port);
    if (!address && server.port != "*") return;
    const std::string_view key = reader.given("tcp_port") ? "tcp_port" : "listen";
    const Interpretation::Listener listener{address, server.tcp_port, {reader, key}};
    const auto first = std::ranges::find_if(
        state.listeners, [&](const Interpretation::Listener& other) { return collide(listener, other); });
    if (first != state.listeners.end())
        reader.report(Rule::server_listen_twice, key, {},
                      {{"first", state.describe(first->use)}, {"port", std::to_string(server.tcp_port)}});
    else
        state.listeners.push_back(listener);
}

void read_server_port(Interpretation& state, Reader& reader, Server& server) {
    const bool network = is_network(server.transport);
    const std::string_view key = network ? "listen" : "port";
    server.port = reader.text(key).value_or("");
    if (server.transport == Transport::tls) server.tcp_port = kModbusTlsPort;
    if (const auto port = reader.integer("tcp_port")) server.tcp_port = static_cast<std::uint16_t>(*port);
    server.tls = read_tls(state, reader, server.transport, "server");
    report_missing_port(reader, key, name(server.transport));
    if (!network)
        register_port(state, reader, server.port);
    else if (!server.port.empty() && check_host(reader, key, server.port))
        note_listener(state, reader, server);
}

std::string at_least(Duration least, std::string_view most) {
    const auto milliseconds = std::chrono::ceil<std::chrono::milliseconds>(least).count();
    return std::to_string(milliseconds) + "ms.." + std::string(most);
}

// A pause below t3.5 ends no RTU frame, and the longest frame must fit into the frame time-out.
void read_serial_times(Reader& reader, Server& server) {
    server.byte_timeout = reader.duration("byte_timeout");
    server.frame_timeout = reader.duration("frame_timeout");
    const bool rtu = server.framing == wire::Framing::rtu;
    const Duration silence = wire::t3_5(server.format);
    if (rtu && !server.strict && server.byte_timeout && *server.byte_timeout < silence)
        reader.report(Rule::field_out_of_range, "byte_timeout", at_least(silence, "65535ms"));
    const Duration longest =
        wire::transmission_time(server.format, rtu ? wire::kMaxRtuFrame : wire::kMaxAsciiFrame);
    if (server.frame_timeout && *server.frame_timeout < longest)
        reader.report(Rule::field_out_of_range, "frame_timeout", at_least(longest, "24h"));
}

ListenLimits read_limits(Reader& reader, bool serial) {
    ListenLimits limits;
    const auto count = [&](std::string_view key, std::uint32_t& limit) {
        if (const auto given = reader.integer(key)) limit = static_cast<std::uint32_t>(*given);
    };
    const auto time = [&](std::string_view key, Duration& limit) {
        limit = reader.duration(key).value_or(limit);
    };
    count("max_connections", limits.max_connections);
    count("max_per_peer", limits.max_per_peer);
    if (!serial) time("frame_timeout", limits.frame_timeout);
    time("idle_timeout", limits.idle_timeout);
    time("write_timeout", limits.write_timeout);
    return limits;
}

void report_server_keys_without_effect(Reader& reader, const Server& server) {
    const std::span<const std::string_view> others = server.transport == Transport::serial
                                                         ? std::span<const std::string_view>(kListenerKeys)
                                                         : kServerSerialKeys;
    report_keys_without_effect(reader, others, name(server.transport));
    if (server.strict && server.transport == Transport::serial && server.framing == wire::Framing::ascii)
        reader.report_without_effect("strict", "framing: ascii");
    if (server.strict && server.transport == Transport::serial && server.framing == wire::Framing::rtu &&
        reader.given("byte_timeout"))
        reader.report_without_effect("byte_timeout", "strict: true");
    if (reader.given("max_per_peer") && server.limits.max_per_peer > server.limits.max_connections)
        reader.report_without_effect("max_per_peer",
                                     "max_connections: " + std::to_string(server.limits.max_connections));
}

void interpret_units(Interpretation& state, Reader& reader, Server& server) {
    const Node* const list = reader.list("units");
    const bool relays = reader.given("relay");
    if (!reader.given("units") && !relays && !reader.misspelt("units"))
        reader.report(reader.node().find("units") != nullptr ? Rule::field_empty : Rule::field_missing,
                      "units", {}, {{"key", "units"}});
    if (list == nullptr) return;
    if (list->items.empty() && !relays) reader.report(Rule::field_empty, "units", {}, {{"key", "units"}});
    state.addresses.clear();
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        const auto path = reader.path_of("units") + "[" + std::to_string(i) + "]";
        server.units.push_back(is_mapping(state, item, path) ? interpret_server_unit(state, item, path)
                                                             : ServerUnit{});
    }
}

using Units = std::bitset<256>;

void add_units(Units& units, const std::vector<ItemRange>& ranges) {
    for (const auto [first, last] : ranges)
        for (std::size_t unit = first; unit <= last && unit < units.size(); ++unit) units[unit] = true;
}

/// Where requests of a server end: units that can execute them, and mappings that are in effect.
struct Ends {
    Units executors;
    std::vector<UnitMapping> mapped;
};

/// Own units go before routes; the first of several routes counts.
Ends ends_of(const Server& server) {
    Ends ends;
    Units taken;
    for (const ServerUnit& unit : server.units) taken[unit.address.value] = true;
    ends.executors = taken;
    for (const Relay& relay : server.relays) {
        for (const UnitMapping& mapping : relay.map) {
            if (taken[mapping.from.value]) continue;
            taken[mapping.from.value] = ends.executors[mapping.to.value] = true;
            ends.mapped.push_back(mapping);
        }
        Units same;
        add_units(same, relay.units);
        ends.executors |= same & ~taken;
        taken |= same;
    }
    if (ends.executors[kBroadcast.value]) ends.executors.set();
    return ends;
}

/// Access rules name the units behind a map. A rule for the unit before it never matches.
void report_mapped_units(Interpretation& state, Reader& reader, const Server& server) {
    const Ends ends = ends_of(server);
    for (std::size_t i = 0; i < server.access.size(); ++i) {
        Units named;
        add_units(named, server.access[i].units);
        for (const auto [from, to] : ends.mapped) {
            if (!named[from.value] || named[to.value] || ends.executors[from.value]) continue;
            const auto unit = std::to_string(from.value);
            const auto target = std::to_string(to.value);
            state.findings.add(
                Rule::field_without_effect, server.access[i].location,
                reader.path_of("access") + "[" + std::to_string(i) + "].units", unit, {},
                {{"key", "units: " + unit}, {"condition", "map: {from: " + unit + ", to: " + target + "}"}});
        }
    }
}

}  // namespace

Server interpret_server(Interpretation& state, const Node& node, const std::string& path) {
    state.context = Context{.profile = state.context.profile, .transport = Transport::tcp};
    Reader reader(state.findings, node, path, Object::server, state.context);
    Server server;
    server.location = node.location;
    server.name = read_name(state, reader, state.line_names);
    server.transport = state.context.transport =
        reader.choice<Transport>("transport").value_or(Transport::tcp);
    const bool serial = server.transport == Transport::serial;
    server.framing = state.context.framing =
        reader.choice<wire::Framing>("framing").value_or(serial ? wire::Framing::rtu : wire::Framing::tcp);
    read_server_port(state, reader, server);
    server.format = read_character_format(reader, server.framing);
    server.rs485 = reader.choice<Rs485>("rs485").value_or(server.rs485);
    server.strict = reader.boolean("strict").value_or(server.strict);
    server.turnaround = reader.duration("turnaround").value_or(server.turnaround);
    server.limits = read_limits(reader, serial);
    if (serial)
        read_serial_times(reader, server);
    else
        server.byte_timeout = reader.duration("byte_timeout");
    server.access = read_access(state, reader);
    server.audit = reader.text("audit").value_or("");
    report_server_keys_without_effect(reader, server);
    interpret_units(state, reader, server);
    interpret_relays(state, reader, server.relays);
    report_mapped_units(state, reader, server);
    return server;
}

}  // namespace takt::model
