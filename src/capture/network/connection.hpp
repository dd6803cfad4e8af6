// One TCP connection: both directions, and the requests in flight.
#pragma once

#include <cstdint>
#include <optional>

#include "network/mbap_stream.hpp"
#include "network/request_queue.hpp"
#include "serial/serial_stream.hpp"
#include "takt/capture/tcp_analyzer.hpp"
#include "takt/capture/tcp_stream.hpp"

namespace takt::capture {

/// The ends of a connection, the same for both directions.
struct ConnectionKey {
    Endpoint low;
    Endpoint high;
    friend constexpr bool operator==(const ConnectionKey&, const ConnectionKey&) = default;
};
[[nodiscard]] ConnectionKey key_of(const Segment& segment);

/// Which end of a connection is the server, and how that is known.
struct Roles {
    bool server_is_high = false;
    bool certain = false;  ///< by the port; otherwise the bytes must show that this is Modbus
};

class Connection {
public:
    Connection(const ConnectionKey& key, Roles roles, const TcpAnalyzerConfig& config, TcpCounts& counts,
               ExchangeSink& sink);
    Connection(const Connection&) = delete;
    Connection& operator=(const Connection&) = delete;

    void on_segment(const Segment& segment, const PacketRef& packet);
    /// Passes what waits and reports the requests without a response. Adds the counts.
    void finish(NoResponse why);

    [[nodiscard]] const ConnectionKey& key() const { return key_; }

private:
    /// The bytes that one end sent.
    class Direction final : public StreamSink, public AduSink {
    public:
        Direction(Connection& connection, bool from_high, bool certain)
            : connection_(connection), from_high_(from_high), mbap_(certain) {}
        /// The messages are frames of this framing from the next byte on. @param framing  rtu or ascii
        void use(wire::Framing framing) { serial_.emplace(framing); }
        void on_data(const PacketRef& packet, Bytes bytes) override;
        void on_gap() override;
        void on_cut(const PacketRef& packet, std::size_t count) override;
        /// The first byte has that sequence number.
        void begin(std::uint32_t sequence);
        /// Another connection began; its first bytes are not known.
        void restart();
        [[nodiscard]] std::uint64_t messages() const {
            return serial_ ? serial_->messages() : mbap_.messages();
        }
        void add_counts(TcpCounts& counts) const;
        void on_adu(const Adu& adu) override { connection_.on_adu(from_high_, adu); }

    private:
        [[nodiscard]] bool finds_framing(const PacketRef& packet, Bytes bytes);

        Connection& connection_;
        bool from_high_;
        MbapStream mbap_;
        std::optional<SerialStream> serial_;  // instead of mbap_

    public:
        TcpStream stream;
        bool ended = false;
    };

    [[nodiscard]] Direction& from(bool high) { return high ? high_ : low_; }
    void on_syn(Direction& sender, Direction& receiver, const Segment& segment);
    void close();
    void on_adu(bool from_high, const Adu& adu);
    [[nodiscard]] bool seeks_framing() const;
    void use(wire::Framing framing);
    void check_roles(bool from_high, Bytes pdu);
    void on_request(const Adu& adu);
    void on_response(const Adu& adu);
    void settle(NoResponse why);
    [[nodiscard]] std::uint64_t retransmissions() const;
    [[nodiscard]] ObservedRequest observed(const RequestQueue::Waiting& waiting) const;

    ConnectionKey key_;
    wire::Framing framing_ = wire::Framing::tcp;
    const TcpAnalyzerConfig& config_;
    TcpCounts& counts_;
    ExchangeSink& sink_;
    Roles roles_;
    bool roles_known_;
    bool closed_ = false;
    Direction low_;
    Direction high_;
    RequestQueue waiting_;
};

}  // namespace takt::capture
