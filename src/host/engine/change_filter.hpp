// Which changes of the state of a device are shown.
#pragma once

#include <cstdint>

#include "takt/base/time.hpp"
#include "takt/host/event.hpp"

namespace takt::host {

/// The first kShown changes are shown. With the next one the device changes often: that is shown once, and
/// once when no change came for kQuiet. Time must not run backwards.
class ChangeFilter {
public:
    using Shown = DeviceStateChanged::Shown;
    static constexpr std::uint64_t kShown = 5;
    static constexpr Duration kQuiet = std::chrono::seconds(30);

    /// The state changes. ended() comes before it.
    Shown changed(Instant t) {
        if (ended_ || count_ == 0 || quiet(t)) {
            ended_ = false;
            count_ = 0;
            since_ = t;
        }
        last_ = t;
        ++count_;
        return count_ <= kShown ? Shown::each : count_ == kShown + 1 ? Shown::often : Shown::counted;
    }

    /// It changed often, and is steady now: true once. count() and in() are those of all changes.
    /// @param finish  nothing follows
    bool ended(Instant t, bool finish = false) {
        if (ended_ || count_ <= kShown || (!finish && !quiet(t))) return false;
        return ended_ = true;
    }

    /// No change came for kQuiet.
    [[nodiscard]] bool quiet(Instant t) const { return t >= after(last_, kQuiet); }
    /// Of changes without a pause of kQuiet.
    [[nodiscard]] std::uint64_t count() const { return count_; }
    [[nodiscard]] Duration in() const { return last_ - since_; }

private:
    std::uint64_t count_ = 0;
    bool ended_ = false;
    Instant since_;
    Instant last_;
};

}  // namespace takt::host
