// The proof rounds periods down to microseconds, also the tick of several requests that alternate. Periods of
// whole microseconds have whole ticks, so the proof counts at least this load. Devices with other periods are
// left out.
#include "cost/polling_load.hpp"

#include <algorithm>

#include "timing/streams.hpp"

namespace takt::plan {
namespace {

using std::chrono::microseconds;

bool has_whole_period(const Request& request) {
    return *request.period % microseconds(1) == Duration::zero();
}

}  // namespace

void PollingLoad::add(std::span<const Request> requests) {
    double load = 0;
    for (const Request& request : requests) {
        if (!is_periodic(request)) continue;
        if (!has_whole_period(request)) return;
        Microseconds cost = 0;
        for (const TransactionCost& each : costs_.of_read(request)) cost += each.transaction;
        load += static_cast<double>(cost) / static_cast<double>(*request.period / microseconds(1));
    }
    load_ += load;
}

}  // namespace takt::plan
