#include "network/connection.hpp"

#include "exchanges/pdu_shape.hpp"
#include "takt/wire/function.hpp"

namespace takt::capture {
namespace {

bool is_less(const Endpoint& a, const Endpoint& b) {
    return a.port != b.port ? a.port < b.port : a.address.bytes < b.address.bytes;
}

}  // namespace

ConnectionKey key_of(const Segment& segment) {
    if (is_less(segment.destination, segment.source)) return {segment.destination, segment.source};
    return {segment.source, segment.destination};
}

Connection::Connection(const ConnectionKey& key, Roles roles, const TcpAnalyzerConfig& config,
                       TcpCounts& counts, ExchangeSink& sink)
    : key_(key),
      config_(config),
      counts_(counts),
      sink_(sink),
      roles_(roles),
      roles_known_(roles.certain),
      low_(*this, false, roles.certain),
      high_(*this, true, roles.certain) {
    if (config.framing && *config.framing != wire::Framing::tcp) use(*config.framing);
}

void Connection::use(wire::Framing framing) {
    framing_ = framing;
    low_.use(framing);
    high_.use(framing);
}

bool Connection::seeks_framing() const {
    return !config_.framing && framing_ == wire::Framing::tcp && low_.messages() + high_.messages() == 0;
}

void Connection::Direction::on_data(const PacketRef& packet, Bytes bytes) {
    if (finds_framing(packet, bytes)) return;
    if (serial_)
        serial_->push(packet, bytes, *this);
    else
        mbap_.push(packet, bytes, *this);
}

// 16 bits of checksum beside the form of the PDU leave hardly a chance that this is something else. If the
// frame is cut into segments, its first bytes wait for a message of Modbus TCP.
bool Connection::Direction::finds_framing(const PacketRef& packet, Bytes bytes) {
    if (!connection_.seeks_framing() || mbap_.is_foreign()) return false;
    wire::FrameBytes joined;
    const auto begun = mbap_.pending();
    if (begun.size() + bytes.size() <= joined.capacity()) {
        joined.append(begun);
        joined.append(bytes);
    }
    for (const Bytes frame : {joined.span(), bytes}) {
        const auto found = serial_framing_of(frame);
        if (!found) continue;
        connection_.use(*found);
        serial_->push(packet, frame, *this);
        return true;
    }
    return false;
}

void Connection::Direction::on_gap() {
    if (serial_)
        serial_->begin();
    else
        mbap_.on_gap();
}

void Connection::Direction::on_cut(const PacketRef& packet, std::size_t count) {
    if (serial_)
        serial_->begin();
    else
        mbap_.on_cut(packet, count, *this);
}

void Connection::Direction::begin(std::uint32_t sequence) {
    ended = false;
    stream.flush(*this);
    stream.begin(sequence);
    if (serial_)
        serial_->begin();
    else
        mbap_.begin_aligned();
}

void Connection::Direction::restart() {
    ended = false;
    stream.flush(*this);
    stream.forget();
    if (serial_)
        serial_->begin();
    else
        mbap_.restart();
}

void Connection::Direction::add_counts(TcpCounts& counts) const {
    counts.streams.add(stream.counts());
    counts.resynchronisations += mbap_.resynchronisations();
    counts.skipped_bytes += serial_ ? serial_->skipped_bytes() : mbap_.skipped_bytes();
}

// The acknowledgement comes first: a response acknowledges its request, of which segments may be missing.
void Connection::on_segment(const Segment& segment, const PacketRef& packet) {
    const bool from_high = segment.source == key_.high;
    auto& sender = from(from_high);
    auto& receiver = from(!from_high);
    if (segment.syn) {
        on_syn(sender, receiver, segment);
    } else if (closed_ && segment.length > 0 && sender.stream.is_beyond(segment.sequence)) {
        closed_ = false;  // another connection, whose SYN was not captured
        sender.restart();
        receiver.restart();
    }
    if (segment.ack) receiver.stream.acknowledged(segment.acknowledged, receiver);
    if (segment.length > 0 && !segment.syn) sender.stream.push(segment, packet, sender);
    if (segment.fin) {
        sender.stream.end_at(segment.sequence + segment.length);
        sender.ended = true;
    }
    if (segment.rst || (sender.ended && receiver.ended)) close();
}

void Connection::close() {
    if (!closed_) settle(NoResponse::unanswered);
    closed_ = true;
}

// A SYN with another number opens a new connection between the same ports, also if the capture has only one
// of the two. The SYN of a server acknowledges that of its client.
void Connection::on_syn(Direction& sender, Direction& receiver, const Segment& segment) {
    const std::uint32_t first = segment.sequence + 1;
    const bool known = sender.stream.begun();
    if (known && sender.stream.next() == first && !closed_) return;
    if (!segment.ack) {
        settle(NoResponse::unanswered);
        if (receiver.stream.begun()) receiver.restart();
    } else if ((known || !receiver.stream.begun()) && receiver.stream.next() != segment.acknowledged) {
        settle(NoResponse::unanswered);
        receiver.begin(segment.acknowledged);
    }
    closed_ = false;
    sender.begin(first);
    if (roles_known_ && roles_.certain) return;
    roles_.server_is_high = (&sender == &high_) == segment.ack;
    roles_known_ = true;
}

void Connection::on_adu(bool from_high, const Adu& adu) {
    if (!roles_known_) check_roles(from_high, adu.pdu);
    if (from_high == roles_.server_is_high)
        on_response(adu);
    else
        on_request(adu);
}

/// Corrects a guess by a message that can only be a request, or only a response.
void Connection::check_roles(bool from_high, Bytes pdu) {
    const bool request = could_be_request(pdu);
    if (request == could_be_response(pdu)) return;
    roles_.server_is_high = request != from_high;
    roles_known_ = true;
}

void Connection::on_request(const Adu& adu) {
    while (const auto expired = waiting_.take_expired(adu.packet.time_ns, config_.forget))
        sink_.on_no_response(observed(*expired), NoResponse::unanswered);
    // Without transaction ids the next request gives up the one before it.
    if (framing_ != wire::Framing::tcp)
        while (const auto before = waiting_.take_oldest())
            sink_.on_no_response(observed(*before), NoResponse::unanswered);
    const RequestQueue::Waiting request{.transaction = adu.transaction,
                                        .unit = adu.unit,
                                        .function = adu.pdu[0],
                                        .items = items_of(adu.pdu),
                                        .packet = adu.packet,
                                        .retransmissions = retransmissions()};
    sink_.on_request(observed(request));
    const bool on_serial_line = framing_ != wire::Framing::tcp || adu.packet.serial_broadcast;
    if (on_serial_line && adu.unit == kBroadcast.value)
        return sink_.on_no_response(observed(request), NoResponse::broadcast);
    if (waiting_.push(request)) ++counts_.repeated_ids;
}

void Connection::on_response(const Adu& adu) {
    const auto request = waiting_.take(adu);
    if (!request) {
        ++counts_.unmatched;
        return;
    }
    const bool is_exception = wire::is_exception(adu.pdu[0]) && adu.pdu.size() > 1;
    sink_.on_response(observed(*request), {.packet = adu.packet,
                                           .exception = is_exception ? adu.pdu[1] : std::uint8_t{0},
                                           .retransmissions = retransmissions() - request->retransmissions});
}

void Connection::settle(NoResponse why) {
    low_.stream.flush(low_);
    high_.stream.flush(high_);
    while (const auto request = waiting_.take_oldest()) sink_.on_no_response(observed(*request), why);
}

void Connection::finish(NoResponse why) {
    settle(why);
    for (const auto* direction : {&low_, &high_}) {
        direction->add_counts(counts_);
    }
    const bool has_messages = low_.messages() + high_.messages() > 0;
    if (has_messages && framing_ != wire::Framing::tcp) ++counts_.serial_framing;
    if (has_messages || roles_.certain)
        ++counts_.connections;
    else
        ++counts_.foreign;
}

std::uint64_t Connection::retransmissions() const {
    std::uint64_t sum = 0;
    for (const auto* direction : {&low_, &high_})
        sum += direction->stream.counts().retransmissions + direction->stream.counts().overlaps;
    return sum;
}

ObservedRequest Connection::observed(const RequestQueue::Waiting& waiting) const {
    return {.route = {.client = roles_.server_is_high ? key_.low : key_.high,
                      .server = roles_.server_is_high ? key_.high : key_.low},
            .transaction = waiting.transaction,
            .unit = waiting.unit,
            .function = waiting.function,
            .items = waiting.items,
            .packet = waiting.packet};
}

}  // namespace takt::capture
