// Limits simultaneous connection attempts, for example at the start or when a switch comes back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>

#include "takt/base/token_bucket.hpp"
#include "takt/line/loop.hpp"

namespace takt::line {

/// Limits of the attempts in progress and of their rate.
struct ConnectLimits {
    std::size_t most = 128;  ///< attempts in progress
    /// An attempt without a result after this time no longer counts, so that silent hosts do not delay
    /// others.
    Duration undecided_limit = std::chrono::milliseconds(100);
    std::uint16_t burst = 16;                            ///< attempts begun at once
    Duration interval = std::chrono::microseconds(200);  ///< then one more per interval
};

/// The gate for all attempts of one loop, first come, first served. An attempt that hangs or is refused
/// delays no other one: `most` limits the attempts in progress, `burst` and `interval` limit the rate of all.
///
/// The loop must outlive the gate, and the gate every Pass. The loop's thread only.
class ConnectGate {
public:
    explicit ConnectGate(Loop& loop, const ConnectLimits& limits = {});
    ConnectGate(const ConnectGate&) = delete;
    ConnectGate& operator=(const ConnectGate&) = delete;

    /// A queued attempt, later an attempt in progress. Destroying it ends the attempt.
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
        void swap(Pass& other) noexcept {
            std::swap(gate_, other.gate_);
            std::swap(ticket_, other.ticket_);
        }
        ConnectGate* gate_ = nullptr;
        std::uint64_t ticket_ = 0;
    };

    /// Calls `admitted` when the attempt may start, if the pass still exists. Called from the loop, never
    /// from inside ask().
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
