#include "takt/bus/unit_times.hpp"

#include <algorithm>
#include <utility>

#include "takt/wire/frame.hpp"

namespace takt::bus {
namespace {

constexpr int kRecentResponses = 16;   // over which the longest delay decays
constexpr int kDoubtfulResponses = 4;  // over which it grows if they may be late ones
constexpr int kLongestHold = 8;        // response time-outs
constexpr int kPatienceFactor = 4;     // a quarter longer than late responses usually take

}  // namespace

// The bytes of an ambiguous response are not known any more; it had the expected length.
Duration response_delay(const LineConfig& config, const Outcome& outcome) {
    const std::size_t pdu =
        outcome.response.empty() ? outcome.request.response_length : outcome.response.pdu().size();
    return outcome.ended_at - config.frame_time(pdu) - outcome.request_end;
}

// A delay seems short if the response is that to the request before. It seems long if it is that to an
// earlier one; but a unit that has become slower must not stay in doubt.
void UnitTimes::on_response(Duration delay, bool certain) {
    const Duration longest = longest_delay.value_or(delay);
    if (!certain)
        longest_delay = longest + std::max(delay - longest, Duration::zero()) / kDoubtfulResponses;
    else
        longest_delay = std::max(delay, longest - (longest - delay) / kRecentResponses);
}

void UnitTimes::on_late(const LateResponse& late) {
    lateness = std::max(lateness, late.delay);
    std::ranges::rotate(last_late, last_late.begin() + 1);
    last_late.back() = late.delay;
    missing = false;
    step.on_late(late.at, late.shape);
    if (late.out_of_order_since) in_order = false;
}

Duration UnitTimes::usual_lateness() const {
    Duration least = Duration::max();
    Duration second = Duration::max();
    for (const Duration delay : last_late) {
        if (delay < least)
            second = std::exchange(least, delay);
        else
            second = std::min(second, delay);
    }
    return least > Duration::zero() ? second : Duration::zero();
}

void UnitTimes::set(Transaction& transaction, Duration response_timeout) const {
    transaction.late_limit =
        std::clamp<Duration>(kLatenessFactor * lateness, response_timeout, kLongestHold * response_timeout);
    transaction.lateness = usual_lateness();
    transaction.longest_delay = longest_delay;
    transaction.in_order = in_order;
    const bool comes = in_order && !missing;
    transaction.patience =
        comes ? transaction.lateness + transaction.lateness / kPatienceFactor : Duration::zero();
}

}  // namespace takt::bus
