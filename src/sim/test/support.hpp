// Shared by the tests of this module: a scripted engine, and a record of the traffic on the wire.
#pragma once

#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/sim/wire.hpp"

namespace takt::sim {

using ByteVector = std::vector<std::uint8_t>;

/// Sends given bytes at given times; keeps the received bytes, with the time.
class Talker final : public Engine {
public:
    void send(Instant when, ByteVector bytes) { script_.emplace_back(when, std::move(bytes)); }

    void on_link(Instant, bool is_up) override { up = is_up; }
    void on_bytes(Instant t, Bytes bytes) override {
        received.emplace_back(t, ByteVector(bytes.begin(), bytes.end()));
        all.insert(all.end(), bytes.begin(), bytes.end());
    }
    void on_tick(Instant) override {}
    [[nodiscard]] Bytes transmit(Instant t) override {
        if (!up || script_.empty() || script_.front().first > t) return {};
        current_ = std::move(script_.front().second);
        script_.pop_front();
        return current_;
    }
    [[nodiscard]] Instant next_wakeup() const override {
        return up && !script_.empty() ? script_.front().first : kNever;
    }

    bool up = false;
    std::vector<std::pair<Instant, ByteVector>> received;
    ByteVector all;

private:
    std::deque<std::pair<Instant, ByteVector>> script_;
    ByteVector current_;
};

/// The measured view, kept.
class Record final : public WireObserver {
public:
    struct Entry {
        std::size_t sender;
        Instant start, end;
        ByteVector bytes;
        bool collided;
        friend bool operator==(const Entry&, const Entry&) = default;
    };
    void on_transmission(const Transmission& t) override {
        entries.push_back({t.sender, t.start, t.end, ByteVector(t.bytes.begin(), t.bytes.end()), t.collided});
    }
    /// The shortest time from the end of one entry to the start of the next.
    [[nodiscard]] Duration least_silence() const {
        Duration least = Duration::max();
        for (std::size_t i = 1; i < entries.size(); ++i)
            least = std::min(least, entries[i].start - entries[i - 1].end);
        return least;
    }
    std::vector<Entry> entries;
};

inline Instant at(Duration since_start) {
    return Instant{} + since_start;
}

}  // namespace takt::sim
