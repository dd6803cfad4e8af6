#include "takt/report/times/traffic_capture.hpp"

#include "takt/base/network.hpp"
#include "takt/line/serial_port.hpp"

namespace takt::report {
namespace {

constexpr Duration kTimeout = std::chrono::seconds(1);  // a repeated write after it is a request
constexpr std::size_t kMostSources = 4096;              // of forgotten generations too

/// The address of the server of a TCP line, where it is an address and not that of all interfaces.
std::string server_address(const model::Line& line) {
    const auto with_port = parse_peer(line.port);
    const auto address = with_port ? with_port : parse_ip(line.port);
    const bool known = address && *address != IpAddress{} && *address != *parse_ip("0.0.0.0");
    return known ? line.port : std::string();
}

/// A TCP connection and a pseudo-terminal have no character times: a response may come before its request
/// would have been sent.
bool has_character_times(const model::Line& line) {
    const bool serial = line.framing != wire::Framing::tcp && line.transport != model::Transport::tcp &&
                        line.transport != model::Transport::tls;
    return serial && (line.transport == model::Transport::simulated || !line::is_pseudo_terminal(line.port));
}

}  // namespace

Instant TrafficCapture::end_of(const host::TrafficRecord& record) {
    const auto* const source = source_of(record);
    const bool sent = record.direction == wire::Direction::sent && !overheard_;
    const bool timed = sent && source && source->format.baud > 0;
    return timed ? record.t + wire::transmission_time(source->format, record.raw.size()) : record.t;
}

TrafficCapture::Source* TrafficCapture::source_of(const host::TrafficRecord& record) {
    const Key key{record.generation, record.source.kind, record.source.index};
    if (const auto known = sources_.find(key); known != sources_.end()) return &known->second;
    const auto line = line_of_(record);
    if (!line) return nullptr;
    if (sources_.size() >= kMostSources) sources_.clear();
    const auto name = line->name.empty() ? line->port : line->name;
    const auto number = numbers_.try_emplace({record.source.kind, name}, numbers_.size()).first->second;
    Source source{.number = number, .name = name, .framing = line->framing, .address = server_address(*line)};
    if (has_character_times(*line)) source.format = line->format;
    for (const auto& device : line->devices) source.devices[device.address.value] = device.name;
    const bool of_server = record.source.kind != host::TrafficSource::Kind::line && !overheard_;
    if (of_server && line->framing != wire::Framing::tcp)
        source.pairing = std::make_shared<capture::SerialPairing>(kTimeout);
    return &sources_.emplace(key, std::move(source)).first->second;
}

// A slave on a line of several receives the responses of the others too.
bool TrafficCapture::is_request(Source& source, const host::TrafficRecord& record) {
    const bool sent = record.direction == wire::Direction::sent;
    const bool of_line = record.source.kind == host::TrafficSource::Kind::line;
    if (!source.pairing || record.fault || record.pdu.empty()) return of_line == sent;
    const auto unit = record.unit.value;
    if (sent) source.own.set(unit);
    const auto known = source.own[unit] ? capture::Sender::master : capture::Sender::unknown;
    const auto sender = sent ? capture::Sender::slave : known;
    const auto role =
        source.pairing->on_frame(record.t.time_since_epoch().count(), unit, record.pdu, sender).role;
    using Role = capture::SerialPairing::Role;
    return !sent && (role == Role::request || role == Role::broadcast);
}

void TrafficCapture::add(const host::TrafficRecord& record, std::int64_t wall_ns, std::string& out) {
    if (record.incident) return;  // the file has frames only
    auto* const source = source_of(record);
    if (!source) return frames_.add_loss(1);
    const bool sent = record.direction == wire::Direction::sent;
    const auto seen = sent ? capture::PacketDirection::sent : capture::PacketDirection::received;
    const auto direction = overheard_ ? capture::PacketDirection::unknown : seen;
    const auto device = source->devices.find(record.unit.value);
    capture::CapturedFrame frame{.wall_ns = wall_ns,
                                 .line = source->number,
                                 .line_name = source->name,
                                 .framing = source->framing,
                                 .request = is_request(*source, record),
                                 .direction = direction,
                                 .unit = record.unit.value,
                                 .pdu = record.pdu,
                                 .raw = record.raw,
                                 .client = record.peer,
                                 .server = source->address};
    if (record.fault)
        frame.fault = wire::name(*record.fault);
    else if (device != source->devices.end())
        frame.device = device->second;
    frames_.add(frame, out);
}

}  // namespace takt::report
