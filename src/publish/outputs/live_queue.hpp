// The live messages of a session: bounded, in order, each until it is acknowledged or of no use.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>

#include "takt/publish/mqtt_session.hpp"

namespace takt::publish {

class LiveQueue {
public:
    explicit LiveQueue(std::size_t capacity) : capacity_(capacity) {}

    /// @returns false: the queue is full
    bool push(LiveMessage&& live);
    /// Goes before all others, also into a full queue.
    void push_front(LiveMessage&& live) { entries_.push_front({.live = std::move(live)}); }
    /// Drops the expired messages that are not in flight. @returns how many
    std::size_t drop_expired(Instant now);

    /// The next message that is not in flight; none: null.
    [[nodiscard]] const MqttMessage* next() const;
    /// next() was handed to the pipe.
    void sent(MqttToken token);
    /// Gives next() its short payload. @returns false: it has none, or has it already
    bool shorten_next();
    /// next() can never be sent.
    void drop_next();

    enum class Settled : std::uint8_t { not_found, accepted, dropped, refused };
    /// The broker answered. A message that the broker's quota refused is sent again.
    Settled settle(MqttToken token, MqttReason reason);
    /// The connection is lost: messages in flight wait again, those for the connection only are dropped.
    /// @returns how many were dropped
    std::size_t on_lost();

    [[nodiscard]] std::size_t size() const { return entries_.size(); }
    [[nodiscard]] std::size_t in_flight() const { return in_flight_; }
    /// The first token of those in flight; 0: there is none.
    [[nodiscard]] MqttToken oldest_in_flight() const;

private:
    struct Entry {
        LiveMessage live;
        MqttToken token = 0;  // 0: not in flight
    };

    [[nodiscard]] auto next_entry() { return std::ranges::find(entries_, MqttToken{0}, &Entry::token); }

    std::size_t capacity_;
    std::deque<Entry> entries_;
    std::size_t in_flight_ = 0;
};

}  // namespace takt::publish
