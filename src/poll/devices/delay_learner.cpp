#include "devices/delay_learner.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "takt/bus/outstanding_responses.hpp"

namespace takt::poll {
namespace {

using Setting = DelayFinding::Setting;

constexpr int kSlowOnes = 3;  // of the last eight responses
constexpr double kPercent = 99.9;

void add_late(model::MeasuredTimes& times, Duration delay) {
    ++times.late;
    for (Duration* each : {&times.lateness, &times.next_latest[0], &times.next_latest[1]})
        if (delay > *each) std::swap(delay, *each);
}

}  // namespace

std::string_view name(DelayFinding::Setting setting) {
    switch (setting) {
        case Setting::response_timeout: return "response_timeout";
        case Setting::turnaround: return "turnaround";
        case Setting::learnt_timeout: return "learnt_timeout";
    }
    return {};
}

DelayLearner::DelayLearner(const model::Device& device, Duration wait, bool grows)
    : device_(&device), wait_(wait), grows_(grows) {
    measured_ = device.times.measured;
    for (const auto& [upper, count] : device.times.counts)
        times_.record(std::min(upper, measured_.longest), count);
    grow();
    if (measured_.usual_lateness() > wait_) note_late(measured_.lateness, wait_);
}

std::optional<DelayFinding> DelayLearner::on_response(Duration delay, Duration tolerated) {
    const bool longer = delay > times_.max();
    times_.record(delay);
    if (longer || times_.count() == model::MeasuredTimes::kEnough) {
        news_ = news_ || device_->learn_turnaround;
        grow();
    }
    if (!device_->turnaround) return std::nullopt;
    const bool slow = delay > tolerated;
    slow_ones_ = static_cast<std::uint8_t>(slow_ones_ << 1 | (slow ? 1 : 0));
    if (slow) add_late(slower_, delay);
    if (!slow || std::popcount(slow_ones_) < kSlowOnes) return std::nullopt;
    return note({.setting = Setting::turnaround, .delay = delay, .limit = *device_->turnaround}, slower_);
}

std::optional<DelayFinding> DelayLearner::on_late(Duration delay, Duration waited) {
    news_ = true;
    add_late(measured_, delay);
    const Duration before = wait_;
    grow();
    if (delay <= waited) return std::nullopt;  // the transaction ended for another reason
    if (!grows_) return note_late(delay, waited);
    return note({.setting = Setting::learnt_timeout, .delay = delay, .limit = before}, measured_);
}

std::optional<DelayFinding> DelayLearner::note_late(Duration delay, Duration waited) {
    const bool by_turnaround =
        device_->turnaround && !device_->response_timeout_set && waited < device_->response_timeout;
    const auto setting = by_turnaround ? Setting::turnaround : Setting::response_timeout;
    const Duration limit = by_turnaround ? *device_->turnaround : device_->response_timeout;
    return note({.setting = setting, .delay = delay, .limit = limit}, measured_);
}

void DelayLearner::grow() {
    const Duration longest = std::max(times_.max(), measured_.lateness);
    if (grows_ && longest > wait_ / 2) wait_ = std::max(wait_, model::learnt_timeout(longest));
}

// The first finding about the time-out replaces one about the turnaround.
std::optional<DelayFinding> DelayLearner::note(DelayFinding found, const model::MeasuredTimes& seen) {
    const auto setting = found.setting;
    if (finding_ && finding_->setting != Setting::turnaround && setting != finding_->setting)
        return std::nullopt;
    const bool same = finding_ && finding_->setting == setting;
    if (same) found.delay = std::max(found.delay, finding_->delay);
    found.count = seen.late;
    if (setting == Setting::learnt_timeout) {
        found.advised = wait_;
    } else if (seen.usual_lateness() > found.limit) {
        found.advised = bus::advised_timeout(seen.usual_lateness());
        found.later = seen.later_than(found.advised);
    }
    const bool report = !same || found.advised > finding_->advised;
    finding_ = found;
    return report ? finding_ : std::nullopt;
}

model::MeasuredTimes DelayLearner::measured() const {
    auto made = measured_;
    made.exchanges = times_.count();
    made.longest = times_.max();
    made.p999 = times_.percentile(kPercent);
    return made;
}

model::LearntTimes DelayLearner::learnt() const {
    model::LearntTimes made{.measured = measured(), .counts = {}};
    for (std::size_t i = 0; i < CompactHistogram::kBuckets; ++i)
        if (const auto bucket = times_.histogram().bucket(i); bucket.count > 0)
            made.counts.push_back({std::min(bucket.upper, CompactHistogram::kLimit), bucket.count});
    return made;
}

bool DelayLearner::take_news() {
    return std::exchange(news_, false);
}

void DelayLearner::take_over(const DelayLearner& old, bool same_settings) {
    measured_ = old.measured_;
    times_ = old.times_;
    slow_ones_ = old.slow_ones_;
    slower_ = old.slower_;
    news_ = old.news_;
    finding_ = same_settings ? old.finding_ : std::nullopt;
    if (grows_ && old.grows_) wait_ = std::max(wait_, old.wait_);
    grow();
}

}  // namespace takt::poll
