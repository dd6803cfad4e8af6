// The two clocks of a run.
#pragma once

#include <cstdint>

#include "takt/base/time.hpp"

namespace takt::gatewaysim {

struct Clock {
    Instant now;
    std::int64_t wall_offset_ns = 1'767'225'600'000'000'000;  ///< wall time minus virtual time; it jumps

    [[nodiscard]] std::int64_t wall_ns(Instant t) const {
        return t.time_since_epoch().count() + wall_offset_ns;
    }
    [[nodiscard]] std::int64_t wall_ns() const { return wall_ns(now); }
};

}  // namespace takt::gatewaysim
