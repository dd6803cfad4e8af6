// The driver's loop of the engine contract (takt/base/engine.hpp) between one engine and one open port or
// connection.
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
    /// Read nothing while the engine's bytes wait to be written: a slave is not to be asked faster than it
    /// is listened to. A master goes on reading.
    bool pause_reading = false;
    /// How many bytes the engine can take at a time; asked before every read. 0: nothing is read until it can
    /// take some.
    std::function<std::size_t()> wants_bytes;
    /// Longest time the bytes of one transmit() may wait to be written; zero: no limit.
    Duration write_limit{};
    /// The engine's wake-ups are silences of a line: meet them to the microsecond, for at most 80 us of the
    /// processor's time each.
    bool punctual = false;
    /// The engine wants the stream closed once its bytes are written; asked after every call of the engine.
    std::function<bool()> finished;
    /// Called when the port took `bytes` at `t`.
    std::function<void(Instant t, std::size_t bytes)> written;
};

/// Why a pump ended: an error, or nothing when the engine wanted the stream closed.
using PumpEnd = std::function<void(Instant t, const std::optional<Error>& why)>;

struct PumpCounters {
    std::uint64_t bytes_read = 0;
    std::uint64_t bytes_written = 0;
};

/// Moves bytes and time between an engine and a stream.
///
/// Bytes carry the time taken right after they were read. After every call of the engine its bytes are
/// written; what the stream does not take waits here, and the engine is asked for nothing more until it is
/// gone: so never more than one answer of transmit() waits. One timer follows next_wakeup() and never runs
/// early, so that a silence the engine waits for is never shortened. The engine counts its transmission
/// from the moment it hands the bytes over, a little before they are on the wire; the silence after a
/// response counts from the moment the response was read, a little after it was complete. What the other
/// end sees as silence before a request is therefore never shorter than the engine's. (A USB adapter may
/// begin to send a millisecond after it took the bytes: that shortens only what counts from an own
/// transmission, the turnaround of a broadcast and the deadline of a response, which have a margin.)
///
/// The engine and the stream must outlive the pump. Destroying it does not tell the engine. The loop's
/// thread only.
class Pump {
public:
    Pump(Loop& loop, ByteStream& stream, Engine& engine, PumpOptions options, PumpEnd on_end);
    ~Pump();
    Pump(const Pump&) = delete;
    Pump& operator=(const Pump&) = delete;

    /// Tells the engine that the link is up and begins. May end at once.
    void start();

    /// The engine was changed from outside: asks it for bytes and its next wake-up.
    void poke();

    [[nodiscard]] PumpCounters counters() const { return counters_; }

private:
    void readable();
    void writable();
    void tick(Instant t);
    void service();
    bool write(Bytes bytes);
    [[nodiscard]] std::size_t readable_bytes() const;
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
    std::unique_ptr<Timer> stalled_;     // made when the stream first takes less than all
    std::vector<std::uint8_t> pending_;  // of one transmit(), not yet written
    PumpCounters counters_;
    Instant wakeup_ = kNever;
    bool running_ = false;
};

}  // namespace takt::line
