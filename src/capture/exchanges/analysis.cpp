#include "takt/capture/analysis.hpp"

#include "network/fragments.hpp"
#include "network/mbap_stream.hpp"
#include "takt/base/numbers.hpp"
#include "takt/capture/serial_packet.hpp"

namespace takt::capture {
namespace {

bool is_serial_broadcast(const Packet& packet, const Segment& segment) {
    return segment.payload.size() > kMbapUnitAt && segment.payload[kMbapUnitAt] == kBroadcast.value &&
           SerialPacket(packet).sender() == Sender::master;
}

}  // namespace

Analysis::Analysis(const TcpAnalyzerConfig& tcp, Duration timeout, ExchangeSink& sink)
    : fragments_(std::make_unique<FragmentTable>()), tcp_(tcp, sink), serial_(timeout, sink) {}

Analysis::~Analysis() = default;

void Analysis::on_packet(const Packet& packet) {
    ++packets_.packets;
    if (!packet.timed) {
        ++packets_.untimed;
        return;
    }
    count_time(packet.time_ns);
    if (SerialAnalyzer::is_serial(packet.link)) {
        ++packets_.serial;
        return serial_.on_packet(packet);
    }
    Segment segment;
    Fragment fragment;
    auto content = decode_segment(packet, segment, fragment);
    if (content == Content::fragment) content = reassemble(packet, fragment, segment);
    if (content != Content::segment) return count_other(packet, content);
    ++packets_.segments;
    tcp_.on_segment(segment, {packet.number, packet.time_ns, is_serial_broadcast(packet, segment)});
}

// A datagram has the packet that completed it, as the receiver had it then.
Content Analysis::reassemble(const Packet& packet, const Fragment& fragment, Segment& segment) {
    ++packets_.fragments;
    const auto datagram = fragments_->add(fragment, packet.time_ns);
    packets_.lost_fragments = fragments_->lost();
    return datagram ? decode_datagram(fragment, *datagram, segment) : Content::fragment;
}

void Analysis::end() {
    fragments_->end();
    packets_.lost_fragments = fragments_->lost();
    tcp_.end();
    serial_.end();
}

void Analysis::count_time(std::int64_t time_ns) {
    const bool first = packets_.packets - packets_.untimed == 1;
    if (first) packets_.first_ns = time_ns;
    if (!first && time_ns < packets_.last_ns) ++packets_.backwards;
    packets_.last_ns = time_ns;
}

void Analysis::count_other(const Packet& packet, Content content) {
    switch (content) {
        case Content::other_link:
            if (packets_.other_link++ == 0)
                packets_.first_other_link = static_cast<std::uint16_t>(packet.link);
            break;
        case Content::fragment: break;  // of a datagram that is not complete yet
        case Content::cut: ++packets_.cut; break;
        case Content::malformed: ++packets_.malformed; break;
        case Content::not_ip:
        case Content::not_tcp:
        case Content::segment: ++packets_.other; break;
    }
}

}  // namespace takt::capture
