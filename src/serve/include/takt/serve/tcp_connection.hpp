// The slave end of one connection.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "takt/base/inplace_string.hpp"
#include "takt/serve/answer.hpp"
#include "takt/serve/counters.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/framer.hpp"
#include "takt/wire/traffic.hpp"

namespace takt::serve {

struct TcpConfig {
    wire::Framing framing = wire::Framing::tcp;  ///< tcp, or rtu or ascii frames over the byte stream
    Duration frame_deadline =
        std::chrono::seconds(2);  ///< from the first to the last byte of a frame; zero: none
    Duration idle_deadline = std::chrono::minutes(10);  ///< longest time without any byte; zero: none
    Duration stream_pause =
        std::chrono::milliseconds(500);  ///< RTU: pause after which a broken frame is given up
    InplaceString<64> peer;              ///< Context::peer
    InplaceString<64> role;              ///< Context::role
};

enum class CloseReason : std::uint8_t {
    none,
    bad_header,      ///< the bytes are not Modbus TCP
    frame_deadline,  ///< a frame was begun and not finished
    idle_deadline,
    too_much,  ///< more bytes were given than wants_bytes() said
};
inline constexpr std::size_t kCloseReasons = 5;
std::string_view name(CloseReason reason);

/// Where a busy connection has the requests it has not yet looked at and the answers that are not yet sent.
struct TcpRoom {
    std::array<std::uint8_t, 4096> input;  // a segment of the longest requests in one read
    std::array<std::uint8_t, 4096> output;
};

/// Lends rooms: idle connections, which are most of them, need none.
class TcpRooms {
public:
    /// A room that nobody else has until it is given back. There must be one.
    [[nodiscard]] virtual TcpRoom& lend() = 0;
    virtual void give_back(TcpRoom& room) = 0;

protected:
    ~TcpRooms() = default;
};

/// Answers the requests of one connection in their order, however many come at once. Every request is
/// answered whatever its unit (see Server); there is no broadcast.
///
/// Memory is bounded: kInput bytes not yet looked at and kOutput bytes of answers. The driver
///   - reads at most wants_bytes() bytes at a time and gives them to on_bytes(); 0: it lets the peer wait;
///   - calls transmit() again only when the bytes before are out. A peer that never reads so stops being
///   read, and
///     idle_deadline ends it: on_tick() may be called meanwhile, once the driver keeps its own copy of what
///     is left;
///   - ends the connection when close_reason() is not none, after sending what transmit() still has.
///
/// Never allocates: it works in a room that is lent to it from the first byte of a request until the driver
/// has called transmit() in vain. One owner, one thread; see Engine for the calls.
class TcpConnectionCore : public Engine {
public:
    static constexpr std::size_t kInput = sizeof(TcpRoom::input);
    static constexpr std::size_t kOutput = sizeof(TcpRoom::output);

    /// @param responder, observer, rooms  outlive the engine; the observer may be absent
    /// @param framer_storage  wire::Framer::storage_size(config.framing) bytes, for a frame that is not
    /// whole; outlives it
    TcpConnectionCore(const TcpConfig& config, Responder& responder, TcpRooms& rooms,
                      std::span<std::uint8_t> framer_storage, wire::TrafficObserver* observer = nullptr);
    ~TcpConnectionCore();
    TcpConnectionCore(const TcpConnectionCore&) = delete;
    TcpConnectionCore& operator=(const TcpConnectionCore&) = delete;

    void on_link(Instant t, bool up) override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    [[nodiscard]] Bytes transmit(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override;

    /// How many bytes on_bytes() can take now.
    [[nodiscard]] std::size_t wants_bytes() const;
    [[nodiscard]] CloseReason close_reason() const { return close_; }

    /// Gives the answer to a pending request; the requests behind it have waited for it. Afterwards
    /// transmit() is to be called.
    /// @param pdu  1..253 bytes
    /// @returns false when it is not the one that is waited for (the connection was lost since)
    bool complete(Instant t, Token token, Bytes pdu);

    [[nodiscard]] const Counters& counters() const { return counters_; }

private:
    enum class Waits : std::uint8_t { no, until_due, pending };

    void enter_room();
    void leave_room();
    void forget_sent();
    void process(Instant t);
    void settle(Instant t, const wire::FramerStep& step);
    void take(Instant t, const wire::Frame& frame);
    void release(Instant t);
    void answer(Instant t, UnitId unit, std::uint16_t transaction, Bytes pdu);
    [[nodiscard]] bool room_for_answer() const { return kOutput - output_size_ >= wire::kMaxAsciiFrame; }
    void close(CloseReason reason);
    [[nodiscard]] Instant frame_due() const;
    [[nodiscard]] Instant idle_due() const;

    Responder& responder_;
    wire::TrafficObserver* observer_;
    TcpConfig config_;
    TcpRooms& rooms_;
    wire::Framer framer_;
    Counters counters_;
    bool up_ = false;
    CloseReason close_ = CloseReason::none;
    Instant last_bytes_;
    Instant frame_since_ = kNever;  ///< when the framer got the first byte of the frame it is in
    TcpRoom* room_ = nullptr;       ///< none: nothing is in it
    std::size_t input_size_ = 0;
    std::size_t output_size_ = 0;
    bool output_sent_ = false;  ///< it was handed to the driver and is forgotten at the next call

    // The one request whose answer is not there yet; those behind it stay in the room.
    Waits waits_ = Waits::no;
    Instant due_;
    Token token_ = 0;
    UnitId unit_;
    std::uint16_t transaction_ = 0;
    wire::Pdu pdu_;
};

/// A connection's own room.
class OwnTcpRoom : protected TcpRooms {
protected:
    [[nodiscard]] TcpRoom& lend() final { return room_; }
    void give_back(TcpRoom&) final {}
    ~OwnTcpRoom() = default;

    TcpRoom room_{};
    wire::FramerStorage framer_storage_;
};

/// A connection with its own room.
class TcpConnection final : OwnTcpRoom, public TcpConnectionCore {
public:
    TcpConnection(const TcpConfig& config, Responder& responder, wire::TrafficObserver* observer = nullptr)
        : TcpConnectionCore(config, responder, *this, framer_storage_.framer_storage, observer) {}
};

}  // namespace takt::serve
