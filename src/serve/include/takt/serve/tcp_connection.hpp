// The slave engine of one connection.
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
    /// From the first to the last byte of a frame; zero: none.
    Duration frame_deadline = std::chrono::seconds(2);
    Duration idle_deadline = std::chrono::minutes(10);  ///< longest time without any byte; zero: none
    /// RTU: pause after which an incomplete frame is dropped.
    Duration stream_pause = std::chrono::milliseconds(500);
    InplaceString<64> peer;  ///< Context::peer
    InplaceString<64> role;  ///< Context::role
};

enum class CloseReason : std::uint8_t {
    none,
    bad_header,      ///< the bytes are not Modbus TCP
    frame_deadline,  ///< a frame was not completed in time
    idle_deadline,
    too_much,  ///< more bytes were given than wants_bytes() allowed
};
inline constexpr std::size_t kCloseReasons = 5;

/// Buffers of a busy connection.
struct TcpBuffers {
    std::span<std::uint8_t> input;   ///< unprocessed requests
    std::span<std::uint8_t> output;  ///< unsent answers; wire::kMaxAsciiFrame bytes at least
};

/// The size of both buffers: a segment of the longest requests in one read.
inline constexpr std::size_t kTcpBuffer = 4096;

/// Buffers with their storage.
template <std::size_t Input = kTcpBuffer, std::size_t Output = kTcpBuffer>
struct StoredTcpBuffers final : TcpBuffers {
    static_assert(Output >= wire::kMaxAsciiFrame);

    StoredTcpBuffers() : TcpBuffers{input_storage, output_storage} {}
    StoredTcpBuffers(const StoredTcpBuffers&) = delete;
    StoredTcpBuffers& operator=(const StoredTcpBuffers&) = delete;

    std::array<std::uint8_t, Input> input_storage;
    std::array<std::uint8_t, Output> output_storage;
};

/// Lends buffers. Most connections are idle and need none.
class TcpBufferPool {
public:
    /// Exclusive buffers until release(). Must not fail.
    [[nodiscard]] virtual TcpBuffers& acquire() = 0;
    virtual void release(TcpBuffers& buffers) = 0;
    /// The input of its buffers, in bytes.
    [[nodiscard]] std::size_t input_size() const { return input_size_; }

protected:
    explicit TcpBufferPool(std::size_t input_size = kTcpBuffer) : input_size_(input_size) {}
    ~TcpBufferPool() = default;

private:
    const std::size_t input_size_;
};

/// Answers the requests of one connection in order, also when several arrive at once. Every request is
/// answered for any unit (see Server); there is no broadcast.
///
/// Memory is bounded: the buffers of the pool. The driver
///   - reads at most wants_bytes() bytes at a time and passes them to on_bytes(); 0: the peer must wait;
///   - calls transmit() again only after the previous bytes are written. A peer that does not read is
///     therefore not read either, and idle_deadline ends it. on_tick() may be called meanwhile, if the driver
///     keeps its own copy of the unwritten bytes;
///   - closes the connection when close_reason() is not none, after sending the rest of transmit().
///
/// Never allocates: the buffers are lent from the first byte of a request until transmit() returns nothing.
/// One owner, one thread; see Engine for the calls.
class TcpConnectionCore : public Engine {
public:
    /// @param responder, observer, pool  outlive the engine; the observer may be absent
    /// @param framer_storage  wire::Framer::storage_size(config.framing) bytes for an incomplete frame;
    /// outlives the engine
    TcpConnectionCore(const TcpConfig& config, Responder& responder, TcpBufferPool& pool,
                      std::span<std::uint8_t> framer_storage, wire::TrafficObserver* observer = nullptr);
    ~TcpConnectionCore();
    TcpConnectionCore(const TcpConnectionCore&) = delete;
    TcpConnectionCore& operator=(const TcpConnectionCore&) = delete;

    void on_link(Instant t, bool up) override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    [[nodiscard]] Bytes transmit(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override;

    /// Bytes that on_bytes() can accept now.
    [[nodiscard]] std::size_t wants_bytes() const;
    [[nodiscard]] CloseReason close_reason() const { return close_; }
    /// Whether every request received so far is answered, and the answers were handed over by transmit().
    [[nodiscard]] bool drained() const {
        return waits_ == Waits::no && input_size_ == 0 && (output_size_ == 0 || output_sent_);
    }
    /// When the last byte was received, or the connection was made.
    [[nodiscard]] Instant last_received() const { return last_bytes_; }

    /// Completes the pending request; later requests have waited for it. Afterwards transmit() is to be
    /// called.
    /// @param pdu  1..253 bytes
    /// @returns false if this answer is not the awaited one (the connection was lost since)
    bool complete(Instant t, Token token, Bytes pdu);

    [[nodiscard]] const Counters& counters() const { return counters_; }

private:
    enum class Waits : std::uint8_t { no, until_due, pending };

    void acquire_buffers();
    void release_buffers();
    void forget_sent();
    void process(Instant t);
    void settle(Instant t, const wire::FramerStep& step);
    void take(Instant t, const wire::Frame& frame);
    void release(Instant t);
    void answer(Instant t, UnitId unit, std::uint16_t transaction, Bytes pdu);
    [[nodiscard]] bool room_for_answer() const {
        return !buffers_ || buffers_->output.size() - output_size_ >= wire::kMaxAsciiFrame;
    }
    template <class Call>
    void observe(Call call);
    void close(CloseReason reason);
    [[nodiscard]] Instant frame_due() const;
    [[nodiscard]] Instant idle_due() const;

    Responder& responder_;
    wire::TrafficObserver* observer_;
    TcpConfig config_;
    TcpBufferPool& pool_;
    wire::Framer framer_;
    Counters counters_;
    bool up_ = false;
    CloseReason close_ = CloseReason::none;
    Instant last_bytes_;
    Instant frame_since_ = kNever;   ///< time of the first byte of the incomplete frame
    TcpBuffers* buffers_ = nullptr;  ///< null while the connection is idle
    std::size_t input_size_ = 0;
    std::size_t output_size_ = 0;
    bool output_sent_ = false;  ///< handed to the driver; cleared by the next call

    // The one pending request. Later requests stay in the input buffer.
    Waits waits_ = Waits::no;
    Instant due_;
    Token token_ = 0;
    UnitId unit_;
    std::uint16_t transaction_ = 0;
    wire::Pdu pdu_;
};

/// Buffers of a single connection.
template <std::size_t Input, std::size_t Output>
class OwnTcpBuffers : protected TcpBufferPool {
protected:
    OwnTcpBuffers() : TcpBufferPool(Input) {}
    [[nodiscard]] TcpBuffers& acquire() final { return buffers_; }
    void release(TcpBuffers&) final {}
    ~OwnTcpBuffers() = default;

    StoredTcpBuffers<Input, Output> buffers_;
    wire::FramerStorage framer_storage_;
};

/// A connection with its own buffers.
template <std::size_t Input = kTcpBuffer, std::size_t Output = kTcpBuffer>
class BufferedTcpConnection final : OwnTcpBuffers<Input, Output>, public TcpConnectionCore {
public:
    BufferedTcpConnection(const TcpConfig& config, Responder& responder,
                          wire::TrafficObserver* observer = nullptr)
        : TcpConnectionCore(config, responder, *this, this->framer_storage_.framer_storage, observer) {}
};

using TcpConnection = BufferedTcpConnection<>;

}  // namespace takt::serve
