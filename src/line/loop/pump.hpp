// Connects one engine with one open port or connection: the driver's side of takt/base/engine.hpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/line/byte_stream.hpp"
#include "takt/line/loop.hpp"

namespace takt::line {

struct PumpOptions {
    /// Do not read while output is pending: a slave must not receive requests faster than its answers are
    /// read. A master always reads.
    bool pause_reading = false;
    /// Bytes that the engine can accept now; evaluated before every read. 0: nothing is read.
    std::function<std::size_t()> wants_bytes;
    /// Time limit for writing the bytes of one transmit(); zero: no limit.
    Duration write_limit{};
    /// The engine's wake-ups are silences of a line: meet them to the microsecond by spinning at most 80 us.
    bool punctual = false;
    /// Called when all bytes are written, before `finished`.
    std::function<void()> written_out;
    /// Returns true if the stream is to be closed once all bytes are written. Called after every call of the
    /// engine.
    std::function<bool()> finished;
    /// Returns true if nothing is left to be sent for the bytes received so far. When the peer has closed its
    /// sending side, the pump goes on until then. Empty: it ends at once.
    std::function<bool()> drained;
    /// Called once when the peer has closed its sending side and the pump goes on.
    std::function<void()> input_ended;
    /// A stream that can be made again: its end by the peer, or because the engine asked for it, is a close
    /// (Engine::on_close), not the loss of the link.
    bool reopens = false;
    /// Called when the port accepted `bytes` at `t`.
    std::function<void(Instant t, std::size_t bytes)> written;
};

/// Why a pump ended: an error, or nothing if the engine asked for the end.
using PumpEnd = std::function<void(Instant t, const std::optional<Error>& why)>;

struct PumpCounters {
    std::uint64_t bytes_read = 0;
    std::uint64_t bytes_written = 0;
};

/// Moves bytes and time between an engine and a stream.
///
/// Input: bytes carry the time taken right after they were read. Available bytes reach the engine before
/// on_tick().
/// Output: after every call of the engine its bytes are written. Bytes that the stream does not accept wait
/// here, and transmit() is not called until they are written. So at most one result of transmit() waits.
/// Time: one timer follows next_wakeup() and never expires early, so no silence is shortened. The engine
/// counts its transmission from the moment it hands the bytes over, which is slightly before they are on the
/// wire. It counts the silence after a response from the moment the response was read, which is slightly
/// after it was complete. So the silence on the wire before a request is never shorter than the engine's. (A
/// USB adapter may start to send a millisecond late. That shortens only times that count from an own
/// transmission: the turnaround of a broadcast and the deadline of a response, which have a margin.)
///
/// The engine and the stream must outlive the pump. Destroying it calls no function of the engine. The loop's
/// thread only.
class Pump {
public:
    Pump(Loop& loop, ByteStream& stream, Engine& engine, PumpOptions options, PumpEnd on_end);
    ~Pump();
    Pump(const Pump&) = delete;
    Pump& operator=(const Pump&) = delete;

    /// Reports the link to the engine and starts. The pump may end inside this call.
    void start();

    /// The engine was changed from outside: fetches its bytes and its next wake-up.
    void poke();

    /// Ends the pump as if the engine had asked for it. The pump may be destroyed by the call.
    void stop() { end(std::nullopt); }

    [[nodiscard]] PumpCounters counters() const { return counters_; }

private:
    void readable();
    bool receive();
    void writable();
    void tick(Instant t);
    void service();
    bool write(Bytes bytes);
    [[nodiscard]] std::size_t readable_bytes() const;
    [[nodiscard]] bool is_half_closed(const Error& error) const;
    void arm();
    void limit_waiting(bool waiting);
    void end(const std::optional<Error>& why);

    ByteStream& stream_;
    Engine& engine_;
    PumpOptions options_;
    PumpEnd on_end_;
    Watch watch_;
    Timer timer_;
    Loop& loop_;
    std::unique_ptr<Timer> stalled_;     // created when the stream first accepts less than all
    std::vector<std::uint8_t> pending_;  // rest of one transmit()
    PumpCounters counters_;
    Instant wakeup_ = kNever;
    bool running_ = false;
    std::optional<Error> input_end_;  // the peer sends nothing more
};

}  // namespace takt::line
