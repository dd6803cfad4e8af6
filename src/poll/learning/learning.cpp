// The order of trials, and the knowledge they lead to. learning_answers.cpp handles the results of trials.
#include "learning/learning.hpp"

#include <algorithm>
#include <utility>

#include "takt/base/assert.hpp"

namespace takt::poll {

std::string_view name(GapEvent::Kind kind) {
    switch (kind) {
        case GapEvent::Kind::confirmed: return "confirmed";
        case GapEvent::Kind::refused: return "refused";
        case GapEvent::Kind::too_long: return "too_long";
        case GapEvent::Kind::doubted: return "doubted";
    }
    return "confirmed";
}

namespace {

using model::ItemRange;

constexpr bus::Backoff kLearningBackoff{std::chrono::seconds(1), std::chrono::minutes(1)};
constexpr Duration kBlocked = std::chrono::seconds(10);
constexpr Duration kPause = std::chrono::seconds(5);         // without an answer: plan with what is known
constexpr Duration kAfterReturn = std::chrono::minutes(10);  // not sooner than after the last time
constexpr std::size_t kMaxEvents = 256;

Duration between(Instant earlier, Instant t) {
    return earlier >= t ? Duration::zero() : t - earlier;
}

Instant instant_before(Instant t, Duration age) {
    return t - age;
}

}  // namespace

Learning::Learning(const model::Line& line) {
    for (const auto& device : line.devices) {
        auto& made = devices_.emplace_back();
        if (!plan::learns(device)) continue;
        for (std::size_t a = 0; a < made.areas.size(); ++a) {
            made.areas[a].confirmed = device.learnt.confirmed[a];
            made.areas[a].most_items = device.learnt.most_items[a];
            for (const auto& refused : device.learnt.refused[a])
                made.areas[a].refused.push_back({refused.items, refused.exception,
                                                 instant_before(Instant{}, refused.since),
                                                 instant_before(Instant{}, refused.checked)});
        }
    }
}

void Learning::start(Instant t) {
    if (std::exchange(started_, true)) return;
    for (auto& device : devices_)
        for (auto& area : device.areas)
            for (auto& refused : area.refused) {
                refused.since += t - Instant{};
                refused.checked += t - Instant{};
            }
}

Learning::Area& Learning::area(const plan::Trial& trial) {
    return devices_[trial.device].areas[static_cast<std::size_t>(wire::area_of(trial.read))];
}

// ---- trials

void Learning::set_trials(Instant t, std::vector<plan::Trial> trials) {
    TAKT_ASSERT(!waiting_);
    start(t);
    auto known = std::exchange(runs_, {});
    for (auto& trial : trials) add_run(t, std::move(trial), known);
    cursor_ = 0;
}

// Postponed gaps stay postponed; the gaps on both sides of them become trials of their own.
void Learning::add_run(Instant t, plan::Trial trial, std::vector<Run>& known) {
    const auto same = std::ranges::find(known, trial, &Run::trial);
    if (same != known.end() && !same->stack.empty()) {
        runs_.push_back(std::move(*same));
        known.erase(same);
        return;
    }
    plan::Trial piece{.device = trial.device, .read = trial.read, .gaps = {}, .refused = trial.refused};
    const auto finish_piece = [&] {
        if (!piece.gaps.empty()) runs_.push_back(make_run(t, piece));
        piece.gaps.clear();
    };
    for (const auto& gap : trial.gaps) {
        const auto postponed = std::ranges::find_if(known, [&](const Run& run) {
            return run.postponed && !run.stack.empty() && run.trial.device == trial.device &&
                   run.trial.read == trial.read && run.trial.gaps.front().items == gap.items;
        });
        if (postponed == known.end()) {
            piece.gaps.push_back(gap);
            continue;
        }
        finish_piece();
        runs_.push_back(std::move(*postponed));
        known.erase(postponed);
    }
    finish_piece();
}

Learning::Run Learning::make_run(Instant t, plan::Trial trial) {
    Run run{.trial = std::move(trial), .stack = {}, .silence_backoff = kLearningBackoff};
    run.stack.push_back({.first = 0, .last = run.trial.gaps.size() - 1});
    run.not_before = t;
    if (!run.trial.refused) return run;
    for (const auto& refused : area(run.trial).refused)
        if (model::overlap(refused.items, run.trial.gaps.front().items))
            run.not_before = std::max(run.not_before, recheck_at(refused));
    return run;
}

Instant Learning::recheck_at(const Refused& refused) const {
    const Duration known = between(refused.since, refused.checked);
    return after(refused.checked, std::clamp<Duration>(known, kFirstRecheck, kLastRecheck));
}

// ---- trial reads

ItemRange Learning::range_of(const Run& run, const Node& node) {
    return {run.trial.gaps[node.first].before, run.trial.gaps[node.last].after};
}

std::optional<Learning::TrialRead> Learning::next(Instant t, const FreshnessProbe& probe) {
    if (waiting_) return std::nullopt;
    for (std::size_t n = 0; n < runs_.size(); ++n) {
        const std::size_t index = (cursor_ + n) % runs_.size();
        Run& run = runs_[index];
        if (!ready(t, run, probe)) continue;
        cursor_ = index;
        const auto items = range_of(run, run.stack.back());
        return TrialRead{run.trial.device, {run.trial.read, DataAddress{items.first}, length_of(items)}};
    }
    return std::nullopt;
}

bool Learning::ready(Instant t, Run& run, const FreshnessProbe& probe) {
    if (run.stack.empty() || run.not_before > t) return false;
    const auto freshness =
        probe.freshness(run.trial.device, run.trial.read, range_of(run, run.stack.back()), run.since);
    const bool long_blocked = run.blocked && t >= after(*run.blocked, kBlocked);
    if (freshness != Freshness::refused) {
        if (!long_blocked) run.blocked.reset();
        return freshness == Freshness::good;
    }
    if (!run.blocked) run.blocked = t;
    if (long_blocked) go_round(t, run);
    return false;
}

// A value that the device refuses by itself proves nothing about the gaps beside it: other trials go first.
void Learning::go_round(Instant t, Run& run) {
    const std::size_t top = run.stack.size() - 1;
    if (run.stack[top].first == run.stack[top].last) return postpone(t, run);
    run.stack[top].part_failed = true;
    split(run, top);
}

// ---- observations of polling

void Learning::doubt(std::size_t device, wire::Function read, const ItemRange& items) {
    const plan::Trial about{.device = device, .read = read, .gaps = {}};
    auto& known = area(about);
    known.confirmed = model::without(known.confirmed, {items});
    changed_ = urgent_ = true;
    add_event(GapEvent::Kind::doubted, about, items, 0);
}

void Learning::on_return(Instant t, std::size_t device) {
    for (auto& run : runs_) {
        if (run.trial.device != device || !run.trial.refused || run.stack.empty()) continue;
        Instant last = Instant::min();
        for (const auto& refused : area(run.trial).refused)
            if (model::overlap(refused.items, run.trial.gaps.front().items))
                last = std::max(last, refused.checked);
        run.not_before = std::min(run.not_before, std::max(t, after(last, kAfterReturn)));
    }
}

bool Learning::active(const Run& run) {
    return !run.trial.refused && !run.postponed && !run.stack.empty();
}

bool Learning::wants_plan(Instant t) const {
    if (!changed_ || waiting_) return false;
    return urgent_ || std::ranges::none_of(runs_, active) || t >= after(last_answer_, kPause);
}

Instant Learning::wakeup(Instant t) const {
    Instant wakeup = kNever;
    const auto consider = [&](Instant at) {
        if (at > t) wakeup = std::min(wakeup, at);
    };
    if (changed_) consider(after(last_answer_, kPause));
    for (const auto& run : runs_) consider(run.blocked ? after(*run.blocked, kBlocked) : run.not_before);
    return wakeup;
}

void Learning::add_event(GapEvent::Kind kind, const plan::Trial& trial, const ItemRange& items,
                         std::uint8_t code) {
    if (events_.size() < kMaxEvents) events_.push_back({kind, trial.device, trial.read, items, code});
}

std::optional<GapEvent> Learning::take_event() {
    if (events_.empty()) return std::nullopt;
    const GapEvent event = events_.front();
    events_.erase(events_.begin());
    return event;
}

std::vector<model::Learnt> Learning::learnt(Instant now) const {
    std::vector<model::Learnt> all(devices_.size());
    for (std::size_t d = 0; d < all.size(); ++d)
        for (std::size_t a = 0; a < all[d].refused.size(); ++a) {
            all[d].confirmed[a].reserve(devices_[d].areas[a].confirmed.size());
            all[d].refused[a].reserve(devices_[d].areas[a].refused.size());
        }
    [[maybe_unused]] const bool complete = copy_learnt(now, all);
    return all;
}

bool Learning::copy_learnt(Instant now, std::span<model::Learnt> into) const {
    const Instant t = started_ ? now : Instant{};
    for (std::size_t d = 0; d < devices_.size(); ++d)
        for (std::size_t a = 0; a < devices_[d].areas.size(); ++a) {
            const auto& area = devices_[d].areas[a];
            auto& confirmed = into[d].confirmed[a];
            auto& refused = into[d].refused[a];
            if (confirmed.capacity() < area.confirmed.size() || refused.capacity() < area.refused.size())
                return false;
            confirmed.assign(area.confirmed.begin(), area.confirmed.end());
            refused.clear();
            for (const auto& range : area.refused)
                refused.push_back(
                    {range.items, range.exception, between(range.since, t), between(range.checked, t)});
            into[d].most_items[a] = area.most_items;
        }
    return true;
}

}  // namespace takt::poll
