// The messages of a source that are in flight.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "takt/base/time.hpp"
#include "takt/publish/message_source.hpp"

namespace takt::publish {

/// Moves the cursor of a source in order, although its messages are settled in any order.
class SourceWindow {
public:
    explicit SourceWindow(MessageSource& source) : source_(source) {}

    /// A message was handed to the pipe.
    /// @param token   ascending
    /// @param proved  the broker will acknowledge it (QoS > 0)
    void sent(Instant now, MqttToken token, std::uint64_t of_source, bool proved);
    /// A message can never be sent.
    void unsendable(Instant now, MqttToken token, std::uint64_t of_source, MqttReason reason);

    enum class Settled : std::uint8_t { not_found, accepted, handed_over, rejected, refused };
    /// The broker answered. A refused message stays: blocked() until rewind().
    Settled settle(Instant now, MqttToken token, MqttReason reason);

    /// From sent() to settle() of messages that the broker accepted, smoothed; none: there was none since
    /// rewind().
    [[nodiscard]] std::optional<Duration> round_trip() const { return round_trip_; }
    /// Messages without an answer.
    [[nodiscard]] std::size_t waiting() const { return waiting_; }
    /// The first of them; 0: there is none.
    [[nodiscard]] MqttToken oldest_waiting() const;
    /// Messages behind the cursor: those that wait, and answered ones behind them.
    [[nodiscard]] std::size_t size() const { return entries_.size(); }
    /// The broker refused a message: nothing further may be sent before rewind().
    [[nodiscard]] bool blocked() const { return blocked_; }
    /// All messages behind the cursor are to be read from the source again.
    void rewind();

private:
    enum class Answer : std::uint8_t { none, accepted, rejected, refused };
    struct Entry {
        MqttToken token = 0;
        Instant sent{};
        std::uint64_t of_source = 0;
        Answer answer = Answer::none;
        MqttReason reason = MqttReason::success;
        bool proved = true;
    };

    void move_cursor(Instant now);

    MessageSource& source_;
    std::deque<Entry> entries_;
    std::size_t waiting_ = 0;
    std::optional<Duration> round_trip_;
    bool blocked_ = false;
};

/// Whether a reason of PUBACK says that the message can never be sent.
[[nodiscard]] bool is_final(MqttReason reason);

}  // namespace takt::publish
