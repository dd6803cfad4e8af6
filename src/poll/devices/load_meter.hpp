// The recent load of a line.
#pragma once

#include <algorithm>

#include "takt/base/time.hpp"

namespace takt::poll {

/// The part of the last five to ten seconds that transactions took: a whole window and the one that runs.
/// Nothing in it allocates.
class LoadMeter {
public:
    static constexpr Duration kWindow = std::chrono::seconds(5);

    /// The line is connected.
    void start(Instant t) { *this = LoadMeter(t); }
    /// A transaction that took `busy` ended at `t`, not before that of an earlier call.
    void add(Instant t, Duration busy) {
        roll(t);
        busy_ += busy;
        total_ += busy;
    }
    /// The time that transactions took since start().
    [[nodiscard]] Duration busy() const { return total_; }
    /// 0..1.
    [[nodiscard]] double at(Instant t) const {
        LoadMeter now = *this;
        now.roll(t);
        const Duration time = (t - now.begin_) + (now.has_earlier_ ? kWindow : Duration::zero());
        if (time <= Duration::zero()) return 0;
        const Duration busy = now.busy_ + now.earlier_;
        return std::min(static_cast<double>(busy.count()) / static_cast<double>(time.count()), 1.0);
    }

    LoadMeter() = default;

private:
    explicit LoadMeter(Instant t) : begin_(t) {}

    void roll(Instant t) {
        if (t - begin_ < kWindow) return;
        const auto windows = (t - begin_) / kWindow;
        earlier_ = windows == 1 ? busy_ : Duration::zero();
        has_earlier_ = true;
        busy_ = Duration::zero();
        begin_ += windows * kWindow;
    }

    Instant begin_{};     // of the window that runs
    Duration busy_{};     // in it
    Duration earlier_{};  // in the window before it
    bool has_earlier_ = false;
    Duration total_{};
};

}  // namespace takt::poll
