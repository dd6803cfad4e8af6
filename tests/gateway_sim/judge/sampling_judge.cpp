#include "sampling_judge.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "takt/publish/output_slot.hpp"

namespace takt::gatewaysim {
namespace {

std::optional<double> finite_number(const value::Value& value) {
    if (const auto* i = std::get_if<std::int64_t>(&value)) return static_cast<double>(*i);
    if (const auto* u = std::get_if<std::uint64_t>(&value)) return static_cast<double>(*u);
    if (const auto* d = std::get_if<double>(&value); d && std::isfinite(*d)) return *d;
    return std::nullopt;
}

bool same_state(const host::ValueChanged& a, const value::Value& value, value::Quality quality,
                value::Reason reason) {
    return value::same(a.value, value) && a.quality == quality && a.reason == reason;
}

}  // namespace

SamplingJudge::SamplingJudge(const Clock& clock, const Scenario& scenario, Complaints& complaints)
    : clock_(clock), complaints_(complaints) {
    const auto& configuration = *scenario.configuration;
    const auto& output = configuration.project().outputs.at(0);
    for (const auto& value : output.values) {
        const auto slot = publish::slot_of(configuration.slots(), value.subject);
        const auto& name = configuration.info(slot).name;
        names_[slot.value] = name;
        selected_[name].policy = output.selections.at(value.selection).policy;
    }
}

void SamplingJudge::on_run_begin() {
    for (auto& [name, selected] : selected_) selected = {.policy = selected.policy};
    offsets_.clear();
}

void SamplingJudge::on_event(const host::Event& event) {
    const auto* changed = std::get_if<host::ValueChanged>(&event.body);
    if (changed == nullptr) return;
    const auto name = names_.find(changed->slot.value);
    if (name != names_.end()) selected_[name->second].changes.push_back({event.t, *changed});
}

// What is due by time is due at each step of the sampler. Samples are collected for a while.
void SamplingJudge::after_sampling() {
    constexpr Duration kCollect = std::chrono::milliseconds(60);
    for (const auto& [name, selected] : selected_) {
        const auto& policy = selected.policy;
        // A value that was never read has samples of changes only, of its reason.
        if (!selected.delivered || !selected.state) continue;
        if (selected.state->quality == value::Quality::never_read) continue;
        if (policy.skip_bad) continue;
        const auto late = [&](Duration length, Instant last) {
            return length > Duration{} && last != Instant{} && clock_.now - last > length + kCollect;
        };
        if (late(policy.heartbeat, selected.last_sample) || late(policy.period, selected.last_period))
            complaints_.add("due_sampled", clock_.now, "a sample of " + name + " that is due by time",
                            "none");
    }
}

void SamplingJudge::on_unit(const Unit& unit) {
    if (unit.lost()) {
        for (auto& [name, selected] : selected_)
            selected.losses.push_back({unit.queued.first_wall_ns, unit.queued.last_wall_ns});
        return;
    }
    for (const auto& sample : unit.batch.samples) on_sample(unit.batch.series[sample.series], sample);
}

bool SamplingJudge::is_wall_time(Instant t, std::int64_t wall_ns) const {
    return offsets_.contains(wall_ns - t.time_since_epoch().count());
}

bool SamplingJudge::is_at(const Change& change, const publish::Sample& sample) const {
    if (!same_state(change.what, sample.value, sample.quality, sample.reason)) return false;
    if (sample.cause != publish::SampleCause::change) return true;
    const bool good = sample.quality == value::Quality::good;
    if (!is_wall_time(good && change.what.good_at ? *change.what.good_at : change.t, sample.wall_ns))
        return false;
    const auto& previous = good ? change.what.good_before : change.what.good_at;
    if (!previous) return !sample.previous_wall_ns;
    return sample.previous_wall_ns && is_wall_time(*previous, *sample.previous_wall_ns);
}

// A sample of a change is that of the next one that needs it. All others show the newest state.
void SamplingJudge::on_sample(const publish::Series& series, const publish::Sample& sample) {
    auto& selected = selected_[series.variable];
    const bool of_change = sample.cause == publish::SampleCause::change;
    const std::size_t passed = of_change ? first_match(selected, sample) : last_match(selected, sample);
    if (passed == 0 && (of_change || !shows_state(selected, series, sample)))
        return complaints_.add("sample_true", clock_.now, "a state that " + series.variable + " had",
                               "a sample with cause " + std::string(publish::name(sample.cause)) + " at " +
                                   std::to_string(sample.wall_ns));
    pass(selected, series.variable, passed);
    if (!selected.state)
        selected.state = host::ValueChanged{
            .slot = {}, .value = sample.value, .quality = sample.quality, .reason = sample.reason};
    if (of_change && !selected.policy.on_change)
        complaints_.add("sample_true", clock_.now, "no sample on change of " + series.variable, "one");
    if (selected.policy.skip_bad && sample.quality != value::Quality::good)
        complaints_.add("sample_true", clock_.now, "no sample of bad quality of " + series.variable, "one");
    selected.delivered = selected.state;
    selected.last_sample = clock_.now;
    if (sample.cause == publish::SampleCause::period) selected.last_period = clock_.now;
    // A local may change several times in one instant, which a loss may end.
    std::erase_if(selected.losses, [&](const Loss& loss) { return loss.last_wall_ns < sample.wall_ns; });
}

/// Changes up to the first one that the sample shows; 0: none.
std::size_t SamplingJudge::first_match(const Selected& selected, const publish::Sample& sample) const {
    for (std::size_t i = 0; i < selected.changes.size(); ++i)
        if (is_at(selected.changes[i], sample)) return i + 1;
    return 0;
}

std::size_t SamplingJudge::last_match(const Selected& selected, const publish::Sample& sample) const {
    for (std::size_t i = selected.changes.size(); i > 0; --i)
        if (is_at(selected.changes[i - 1], sample)) return i;
    return 0;
}

/// The state after the changes that were passed. A local has its first one without an event: the first sample
/// shows it.
bool SamplingJudge::shows_state(const Selected& selected, const publish::Series& series,
                                const publish::Sample& sample) {
    if (!selected.state) return series.device.empty();
    return same_state(*selected.state, sample.value, sample.quality, sample.reason);
}

/// The first changes have no sample, but the last of them.
void SamplingJudge::pass(Selected& selected, const std::string& variable, std::size_t changes) {
    for (std::size_t i = 0; i < changes; ++i) {
        const Change change = std::move(selected.changes.front());
        selected.changes.pop_front();
        const bool left_out = i + 1 < changes && needs_sample(selected, change.what);
        if (left_out && !is_lost(selected, change.t)) {
            complaints_.add(
                "change_sampled", clock_.now,
                "a sample of each change of " + variable +
                    ", or a gap before the next one that "
                    "covers it",
                "none of the change at " + std::to_string(change.t.time_since_epoch().count()) + " ns");
        }
        selected.state = change.what;
    }
}

bool SamplingJudge::needs_sample(const Selected& selected, const host::ValueChanged& change) const {
    const auto& policy = selected.policy;
    if (!policy.on_change || (policy.skip_bad && change.quality != value::Quality::good)) return false;
    const auto& last = selected.delivered;
    if (!last || last->quality != change.quality || last->reason != change.reason) return true;
    if (value::same(last->value, change.value)) return false;
    const auto a = finite_number(last->value);
    const auto b = finite_number(change.value);
    return !a || !b || !(std::abs(*b - *a) <= policy.dead_band);
}

bool SamplingJudge::is_lost(const Selected& selected, Instant t) const {
    return std::ranges::any_of(selected.losses, [&](const Loss& loss) {
        return std::ranges::any_of(offsets_, [&](std::int64_t offset) {
            const auto wall = t.time_since_epoch().count() + offset;
            return loss.first_wall_ns <= wall && wall <= loss.last_wall_ns;
        });
    });
}

}  // namespace takt::gatewaysim
