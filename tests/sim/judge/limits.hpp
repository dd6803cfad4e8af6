// memory_bounded and reachable: the limits of a whole run.
#pragma once

#include "case.hpp"

namespace takt::judge {

class Limits {
public:
    static constexpr std::uint64_t kMostSteps = 40'000;  ///< in a second of virtual time
    /// Bytes, after kSettled: full queues, the ledger.
    static constexpr std::size_t kMostGrowth = 1536U * 1024U;
    static constexpr Duration kSettled = std::chrono::minutes(2);

    explicit Limits(Complaints& complaints) : complaints_(complaints) {}

    /// An event at `t`. @returns whether `t` is the first instant after kSettled
    bool step(Instant t) {
        const auto second = t.time_since_epoch() / std::chrono::seconds(1);
        if (second != second_) steps_ = 0;
        second_ = second;
        if (++steps_ == kMostSteps)
            complaints_.add("reachable", t, 0,
                            "virtual time goes on: fewer than " + std::to_string(kMostSteps) +
                                " wake-ups in a second of it",
                            "as many");
        const bool first = !settled_ && t >= Instant{} + kSettled;
        settled_ = settled_ || first;
        return first;
    }

    /// @param then, now  bytes of the heap in use behind kSettled and at the end; 0: not measured
    void end(Instant t, std::size_t then, std::size_t now) {
        if (then != 0 && now > then + kMostGrowth)
            complaints_.add("memory_bounded", t, 0,
                            "at most " + std::to_string(kMostGrowth) + " bytes more than after two minutes",
                            std::to_string(now - then) + " more");
    }

private:
    Complaints& complaints_;
    std::int64_t second_ = -1;
    std::uint64_t steps_ = 0;
    bool settled_ = false;
};

}  // namespace takt::judge
