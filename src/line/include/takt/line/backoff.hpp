// How long to wait before the next attempt to open a port or to connect.
#pragma once

#include <algorithm>

#include "takt/base/time.hpp"

namespace takt::line {

/// 0.25 s, doubling to 5 s.
class Backoff {
public:
    static constexpr Duration kFirst = std::chrono::milliseconds(250);
    static constexpr Duration kLongest = std::chrono::seconds(5);

    /// The pause before the next attempt; the one after it will be twice as long.
    [[nodiscard]] Duration next() {
        const Duration pause = pause_;
        pause_ = std::min(2 * pause_, kLongest);
        return pause;
    }
    /// The last attempt led to something: begin anew.
    void reset() { pause_ = kFirst; }

private:
    Duration pause_ = kFirst;
};

}  // namespace takt::line
