#include "timing/calendar.hpp"

#include <algorithm>
#include <map>
#include <numeric>

#include "takt/base/assert.hpp"

namespace takt::plan {
namespace {

constexpr std::uint8_t kNothingDue = 0xFF;
static_assert(Calendar::kMostProgressions < kNothingDue);

struct Ticks {
    std::int64_t length = 0;  // of a tick in nanoseconds
    std::size_t count = 0;    // in a hyperperiod
};

std::optional<Ticks> ticks_of(std::span<const Duration> periods) {
    Ticks ticks;
    for (const Duration period : periods) ticks.length = std::gcd(ticks.length, period.count());
    std::int64_t count = 1;
    for (const Duration period : periods) {
        const std::int64_t length = period.count() / ticks.length;
        if (length > std::int64_t{Calendar::kMostTicks}) return std::nullopt;
        count = std::lcm(count, length);
        if (count > std::int64_t{Calendar::kMostTicks}) return std::nullopt;
    }
    ticks.count = static_cast<std::size_t>(count);
    return ticks;
}

bool all_left(const std::vector<bool>& left, std::size_t first, std::size_t period) {
    for (std::size_t tick = first; tick < left.size(); tick += period)
        if (!left[tick]) return false;
    return true;
}

/// The ticks first, first + period, … of a hyperperiod.
struct TickProgression {
    std::size_t first = 0;
    std::size_t period = 0;
};

// Divides the ticks in `left` into arithmetic progressions, greedily: the earliest tick left, with the
// shortest period none of whose ticks is missing. Stops as soon as there are more than `most`.
std::vector<TickProgression> tick_progressions(std::vector<bool> left,
                                               const std::vector<std::size_t>& divisors, std::size_t most) {
    std::vector<TickProgression> found;
    for (std::size_t tick = 0; tick < left.size() && found.size() <= most; ++tick) {
        if (!left[tick]) continue;
        const auto period = std::find_if(divisors.begin(), divisors.end(), [&](std::size_t divisor) {
            return divisor > tick && all_left(left, tick, divisor);
        });
        TAKT_ASSERT(period != divisors.end());  // the whole hyperperiod always does
        found.push_back({tick, *period});
        for (std::size_t taken = tick; taken < left.size(); taken += *period) left[taken] = false;
    }
    return found;
}

}  // namespace

std::optional<std::int64_t> common_multiple(std::int64_t a, std::int64_t b, std::int64_t most) {
    const std::int64_t factor = b / std::gcd(a, b);
    if (a > most / factor) return std::nullopt;
    return a * factor;
}

std::optional<Calendar> Calendar::of(std::span<const Duration> periods) {
    TAKT_ASSERT(!periods.empty() && periods.front() > Duration::zero());
    if (periods.size() > kMostPeriods) return std::nullopt;
    const auto ticks = ticks_of(periods);
    if (!ticks) return std::nullopt;
    Calendar calendar;
    calendar.tick_ = Duration(ticks->length);
    calendar.divide(ticks->count);
    calendar.mark(periods);
    if (calendar.due_sets_.size() > kMostProgressions) return std::nullopt;
    for (std::size_t set = 0; set < calendar.due_sets_.size(); ++set) {
        const auto due = calendar.due(std::uint64_t{1} << set);
        calendar.progression_count_ += tick_progressions(due, calendar.divisors_, kMostProgressions).size();
        if (calendar.progression_count_ > kMostProgressions) return std::nullopt;
    }
    return calendar;
}

void Calendar::divide(std::size_t ticks) {
    tick_count_ = ticks;
    for (std::size_t divisor = 1; divisor <= ticks; ++divisor)
        if (ticks % divisor == 0) divisors_.push_back(divisor);
}

void Calendar::mark(std::span<const Duration> periods) {
    std::vector<std::uint32_t> due(tick_count_, 0);
    for (std::size_t i = 0; i < periods.size(); ++i) {
        const auto length = static_cast<std::size_t>(periods[i] / tick_);
        for (std::size_t tick = 0; tick < tick_count_; tick += length) due[tick] |= 1U << i;
    }
    std::map<std::uint32_t, std::size_t> ticks;
    for (const std::uint32_t set : due)
        if (set != 0) ++ticks[set];
    for (const auto& [set, count] : ticks) due_sets_.push_back({set, count});
    set_at_.assign(tick_count_, kNothingDue);
    if (due_sets_.size() > kMostProgressions) return;
    for (std::size_t tick = 0; tick < tick_count_; ++tick) {
        if (due[tick] == 0) continue;
        const auto at = std::lower_bound(due_sets_.begin(), due_sets_.end(), due[tick],
                                         [](const DueSet& a, std::uint32_t set) { return a.periods < set; });
        set_at_[tick] = static_cast<std::uint8_t>(at - due_sets_.begin());
    }
}

std::vector<bool> Calendar::due(std::uint64_t sets) const {
    std::vector<bool> due(tick_count_);
    for (std::size_t tick = 0; tick < tick_count_; ++tick)
        due[tick] = set_at_[tick] != kNothingDue && (sets >> set_at_[tick] & 1U) != 0;
    return due;
}

std::vector<Progression> Calendar::progressions(std::uint64_t sets) const {
    std::vector<Progression> found;
    for (const auto& [first, period] : tick_progressions(due(sets), divisors_, tick_count_))
        found.push_back(
            {tick_ * static_cast<std::int64_t>(period), tick_ * static_cast<std::int64_t>(first)});
    return found;
}

}  // namespace takt::plan
