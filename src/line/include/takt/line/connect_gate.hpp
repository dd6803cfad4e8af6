// Many connections that are all to be made at once, as at the start or when a switch came back, are made one
// after the other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>

#include "takt/base/token_bucket.hpp"
#include "takt/line/loop.hpp"

namespace takt::line {

/// How many attempts to connect are under way, and how fast they follow each other.
struct ConnectLimits {
    std::size_t most = 128;  ///< attempts under way
    /// An attempt that is not decided by then no longer counts: hosts that swallow attempts hold up nobody.
    Duration patience = std::chrono::milliseconds(100);
    std::uint16_t burst = 16;                            ///< attempts begun at once
    Duration interval = std::chrono::microseconds(200);  ///< then one more each
};

/// The gate all attempts of one loop go through, first come, first served. One attempt that hangs or is
/// refused delays no other: `most` bounds those that are quick, and the rate bounds them all.
///
/// The loop must outlive it, and it every Pass. The loop's thread only.
class ConnectGate {
public:
    explicit ConnectGate(Loop& loop, const ConnectLimits& limits = {});
    ConnectGate(const ConnectGate&) = delete;
    ConnectGate& operator=(const ConnectGate&) = delete;

    /// A place in the queue, then an attempt under way; given back when it is destroyed.
    class Pass {
    public:
        Pass() = default;
        Pass(ConnectGate* gate, std::uint64_t ticket) : gate_(gate), ticket_(ticket) {}
        Pass(Pass&& other) noexcept { swap(other); }
        Pass& operator=(Pass&& other) noexcept {
            Pass(std::move(other)).swap(*this);
            return *this;
        }
        ~Pass() {
            if (gate_) gate_->leave(ticket_);
        }

    private:
        void swap(Pass& other) {
            std::swap(gate_, other.gate_);
            std::swap(ticket_, other.ticket_);
        }
        ConnectGate* gate_ = nullptr;
        std::uint64_t ticket_ = 0;
    };

    /// Calls `admitted` from the loop, never from within, as soon as its turn has come and the pass still is.
    [[nodiscard]] Pass ask(std::function<void()> admitted);

    [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }
    [[nodiscard]] std::size_t under_way() const { return under_way_.size(); }

private:
    void leave(std::uint64_t ticket);
    void let_in(Instant t);
    void arm(Instant t);

    ConnectLimits limits_;
    TokenBucket bucket_;
    std::map<std::uint64_t, std::function<void()>> waiting_;  // by ticket: in the order they came
    std::map<std::uint64_t, Instant> under_way_;              // since when; likewise
    std::uint64_t last_ticket_ = 0;
    Timer timer_;
};

}  // namespace takt::line
