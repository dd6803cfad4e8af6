// Cuts the bytes of a line into frames, without knowledge of who sends them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "takt/base/engine.hpp"
#include "takt/base/time.hpp"
#include "takt/wire/frame.hpp"

namespace takt::capture {

/// The last unit of a device (MODBUS over Serial Line V1.02, section 2.2).
inline constexpr std::uint8_t kLastUnit = 247;

/// A frame with a good checksum.
struct LineFrame {
    Instant begin;  ///< when its first character began
    Instant end;    ///< when its last character was complete
    std::uint8_t unit = 0;
    Bytes pdu;  ///< 1..253 bytes, valid during the call
    Bytes raw;  ///< as on the line, valid during the call
};

/// Bytes that belong to no good frame.
struct DamagedBytes {
    Instant begin;
    Instant end;
    Bytes bytes;  ///< valid during the call
};

class LineSink {
public:
    virtual void on_frame(const LineFrame& frame) = 0;
    virtual void on_damaged(const DamagedBytes& damaged) = 0;

protected:
    ~LineSink() = default;
};

struct FrameFinderConfig {
    wire::Framing framing = wire::Framing::rtu;  ///< rtu or ascii
    /// The time of one character: the bytes of one push() follow each other in this distance, the last of
    /// them at its time. Zero: unknown, they all count as received then (a pseudo-terminal).
    Duration character{};
    /// The longest pause inside a frame. Adapters deliver late, so it is longer than t3.5.
    Duration pause = std::chrono::milliseconds(30);
    /// RTU: frames of functions that are not of the specification are damaged bytes. Else such a frame ends
    /// where its checksum is good: random bytes of a frame's length pass for one in 0.4 % of the cases.
    bool known_only = false;
};

/// Receives all bytes of a line, in chunks of any size.
///
/// RTU: a frame is complete when it has the length and the form of a request or of a response, and a good CRC
/// (wire/expected_length.hpp). So frames need no silence between them. Behind bytes that cannot begin a
/// frame, or whose length has passed with a wrong CRC, the next good frame is searched at every position.
/// While the first bytes may still grow to a frame, data inside them cannot pass for one. ASCII: ':' begins a
/// frame, also inside another one; CR LF ends it.
///
/// Holds at most kMost bytes. Never allocates. One owner, one thread; time must not run backwards.
class FrameFinder {
public:
    static constexpr std::size_t kMost = 768;

    FrameFinder(const FrameFinderConfig& config, LineSink& sink) : config_(config), sink_(sink) {}

    /// @param t  when the last of `bytes` arrived
    void push(Instant t, Bytes bytes);
    /// Bytes after which a pause has passed at `t` are damaged.
    void on_tick(Instant t);
    /// When on_tick() can have a result.
    [[nodiscard]] Instant next_wakeup() const;
    /// Nothing follows.
    void end();

private:
    struct Match {
        std::size_t start = 0;
        std::size_t length = 0;  // 0: none
        bool good = false;       // false: damaged bytes
    };

    void append(Instant t, std::uint8_t byte);
    void search(bool closed);
    [[nodiscard]] Match find_rtu(bool closed);
    [[nodiscard]] Match find_ascii() const;
    [[nodiscard]] std::size_t rtu_frame_at(std::size_t start, bool closed) const;
    [[nodiscard]] bool may_grow() const;
    [[nodiscard]] bool has_shape(Bytes frame) const;
    void report_frame(std::size_t start, std::size_t length);
    [[nodiscard]] std::size_t unknown_frame_in(std::size_t count) const;
    void report_damaged(std::size_t count);
    void drop(std::size_t count);
    [[nodiscard]] Bytes bytes() const { return {bytes_.data(), size_}; }
    [[nodiscard]] Instant begin_of(std::size_t index) const;

    FrameFinderConfig config_;
    LineSink& sink_;
    std::array<std::uint8_t, kMost> bytes_{};
    std::array<Instant, kMost> times_{};  // when each was complete
    std::size_t size_ = 0;
    std::size_t tried_ = 0;  // RTU: no frame ends before this position
    Instant last_ = Instant::min();
};

}  // namespace takt::capture
