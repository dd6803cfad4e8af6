#include <span>

#include "servers/interpretation.hpp"

namespace takt::model {
namespace {

using namespace std::chrono_literals;

constexpr std::string_view kLineSerialKeys[] = {"port", "baud", "parity", "stop_bits", "data_bits", "rs485"};

/// The transport as written, even if the profile forbids it: the following keys are checked against it.
Transport stated_transport(Reader& reader, Profile profile) {
    const Node* const node = reader.value("transport");
    if (const auto transport = reader.choice<Transport>("transport")) return *transport;
    if (node != nullptr)
        for (std::size_t i = 0; i < kTransports.size(); ++i)
            if (node->text == kTransports[i]) return static_cast<Transport>(i);
    const bool unknown = node != nullptr || profile == Profile::generic;
    return unknown && names_host(reader) ? Transport::tcp : Transport::serial;
}

void read_line_port(Interpretation& state, Reader& reader, Line& line) {
    const bool network = is_network(line.transport);
    const std::string_view key = network ? "host" : "port";
    line.port = reader.text(key).value_or("");
    if (network) check_host(reader, key, line.port);
    line.tcp_port = line.transport == Transport::tls ? kModbusTlsPort : line.tcp_port;
    if (const auto port = reader.integer("tcp_port")) line.tcp_port = static_cast<std::uint16_t>(*port);
    line.tls = read_tls(state, reader, line.transport, "client");
    reader.text(network ? "port" : "host");
    if (line.transport == Transport::simulated) return;
    report_missing_port(reader, key, name(line.transport));
    if (!network) register_port(state, reader, line.port);
}

void read_line_format(Reader& reader, Line& line) {
    line.format = read_character_format(reader, line.framing);
    if (!line.is_serial()) line.format.baud = 0;
    line.rs485 = reader.choice<Rs485>("rs485").value_or(line.rs485);
}

void read_pace(const Interpretation& state, Reader& reader, Line& line) {
    const bool owen = state.context.profile == Profile::owen_kc1;
    line.order = reader.choice<PollOrder>("order").value_or(owen ? PollOrder::address : PollOrder::deadline);
    line.request_gap = reader.duration("request_gap").value_or(owen ? Duration(12ms) : Duration::zero());
    line.frame_gap = reader.duration("frame_gap").value_or(Duration::zero());
    line.relay_interval = reader.duration("relay_interval").value_or(line.relay_interval);
    line.commands.min_interval = reader.duration("command_interval").value_or(line.commands.min_interval);
    if (const auto burst = reader.integer("command_burst"))
        line.commands.burst = static_cast<std::uint16_t>(*burst);
    line.byte_timeout = reader.duration("byte_timeout");
    if (line.byte_timeout && line.framing == wire::Framing::tcp)
        reader.report_without_effect("byte_timeout", "framing: tcp");
}

void read_connection(Reader& reader, Line& line) {
    auto& rules = line.connection;
    rules.use = reader.choice<ConnectionUse>("connection").value_or(rules.use);
    rules.idle_close = reader.duration("idle_close");
    rules.pause_after = reader.duration("pause_after_connect").value_or(rules.pause_after);
    if (const auto most = reader.integer("connections_per_host"))
        rules.per_host = static_cast<std::uint16_t>(*most);
    line.length_tolerance = reader.boolean("length_tolerance").value_or(false);
    if (!is_network(line.transport)) {
        for (const auto key :
             {"connection", "idle_close", "pause_after_connect", "connections_per_host", "length_tolerance"})
            reader.report_needs(key, "transport: tcp");
        line.connection = {};
        return;
    }
    if (line.framing != wire::Framing::tcp) reader.report_needs("length_tolerance", "framing: tcp");
    const bool on_demand = rules.use == ConnectionUse::on_demand;
    if (!on_demand) reader.report_needs("idle_close", "connection: on_demand");
    if (on_demand && !rules.idle_close) {
        reader.report(Rule::field_missing, "idle_close", {}, {{"key", "idle_close"}});
        line.connection = {};
    }
}

void report_line_keys_without_effect(Reader& reader, const Line& line) {
    if (line.transport == Transport::simulated) return;
    const std::span<const std::string_view> others = line.transport == Transport::serial
                                                         ? std::span<const std::string_view>(kClientKeys)
                                                         : kLineSerialKeys;
    report_keys_without_effect(reader, others, name(line.transport));
}

void note_missing_devices(Interpretation& state, Reader& reader) {
    if (reader.misspelt("devices")) return;
    const Node* const there = reader.node().find("devices");
    const bool wrong = reader.given("devices") && reader.value("devices")->kind != Node::Kind::list;
    if (wrong) return;  // already reported
    state.without_devices.push_back(
        {state.project.lines.size(), there != nullptr ? Rule::field_empty : Rule::field_missing,
         there != nullptr ? there->location : reader.node().location, reader.path_of("devices")});
}

void interpret_devices(Interpretation& state, Reader& reader, Line& line) {
    const Node* const list = reader.list("devices");
    if (list == nullptr || list->items.empty()) note_missing_devices(state, reader);
    if (list == nullptr) return;
    state.addresses.clear();
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        const auto path = reader.path_of("devices") + "[" + std::to_string(i) + "]";
        line.devices.push_back(is_mapping(state, item, path) ? interpret_device(state, item, path)
                                                             : Device{});
    }
}

}  // namespace

Line interpret_line(Interpretation& state, const Node& node, const std::string& path) {
    state.context = Context{.profile = state.context.profile};
    Reader reader(state.findings, node, path, Object::line, state.context);
    Line line;
    line.location = node.location;
    line.name = read_name(state, reader, state.line_names);
    line.transport = state.context.transport = stated_transport(reader, state.context.profile);
    const bool network = is_network(line.transport);
    line.framing = state.context.framing =
        reader.choice<wire::Framing>("framing").value_or(network ? wire::Framing::tcp : wire::Framing::rtu);
    read_line_port(state, reader, line);
    read_line_format(reader, line);
    read_pace(state, reader, line);
    read_connection(reader, line);
    report_line_keys_without_effect(reader, line);
    interpret_devices(state, reader, line);
    return line;
}

}  // namespace takt::model
