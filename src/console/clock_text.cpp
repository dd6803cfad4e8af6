#include "takt/console/clock_text.hpp"

#include "takt/line/loop.hpp"
#include "takt/report/times/history_time.hpp"

namespace takt::console {

std::string iso_time(Instant t) {
    return report::local_time_text(nanoseconds_of(line::wall_clock(t)));
}

}  // namespace takt::console
