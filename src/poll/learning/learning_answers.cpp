// The results of trial reads: bisection. Each run has a stack of nodes (ranges of gaps); a refused node is
// split in halves until the refused gap is alone in one.
#include <algorithm>

#include "learning/learning.hpp"

namespace takt::poll {
namespace {

using model::ItemRange;

constexpr Duration kFirstPostponement = std::chrono::minutes(10);

}  // namespace

void Learning::split(Run& run, std::size_t node) {
    auto& whole = run.stack[node];
    whole.split = true;
    const std::size_t middle = whole.first + (whole.last - whole.first) / 2;
    const Node left{.first = whole.first, .last = middle, .parent = node};
    const Node right{.first = middle + 1, .last = whole.last, .parent = node};
    run.stack.push_back(right);
    run.stack.push_back(left);
}

// Closes the top node, and each node below it whose parts are closed, unless all its parts were accepted:
// then it is tried again. If the first half of a refused node was accepted, the second half is faulty.
void Learning::close(Run& run, bool taken) {
    auto& stack = run.stack;
    bool part_failed = !taken;
    for (;;) {
        const Node settled = stack.back();
        stack.pop_back();
        if (stack.empty()) return;
        auto& parent = stack[settled.parent];
        parent.part_failed = parent.part_failed || part_failed;
        const std::size_t top = stack.size() - 1;
        if (top != settled.parent) {
            stack[top].faulty = taken && parent.faulty && !parent.part_failed;
            if (stack[top].faulty && stack[top].first < stack[top].last) split(run, top);
            return;
        }
        if (!parent.part_failed) return;
        part_failed = true;
        taken = false;
    }
}

void Learning::on_taken(Instant t) {
    Run& run = runs_[cursor_];
    waiting_ = false;
    last_answer_ = t;
    run.silence_backoff.reset();
    const ItemRange items = range_of(run, run.stack.back());
    auto& known = area(run.trial);
    known.longest_taken = std::max(known.longest_taken, length_of(items));
    confirm(run.trial, items);
    close(run, true);
    drop_finished();
}

void Learning::confirm(const plan::Trial& trial, const ItemRange& items) {
    auto& known = area(trial);
    auto confirmed = model::united(known.confirmed, {items});
    if (confirmed.size() > model::Learnt::kMostRanges) return;
    known.confirmed = std::move(confirmed);
    std::erase_if(known.refused, [&](const Refused& r) { return model::overlap(r.items, items); });
    std::erase_if(suspicions_, [&](const Suspicion& s) {
        return s.device == trial.device && s.read == trial.read && model::overlap(s.items, items);
    });
    changed_ = true;
    add_event(GapEvent::Kind::confirmed, trial, items, 0);
}

void Learning::on_refused(Instant t, std::uint8_t code) {
    Run& run = runs_[cursor_];
    waiting_ = false;
    last_answer_ = run.since = t;
    run.silence_backoff.reset();
    const std::size_t top = run.stack.size() - 1;
    auto& node = run.stack[top];
    node.faulty = true;
    if (node.first == node.last) {
        on_gap_refused(t, run, code);
    } else if (node.split) {
        ++node.refused;
        on_whole_refused(run, code);
    } else {
        split(run, top);
    }
    drop_finished();
}

void Learning::on_gap_refused(Instant t, Run& run, std::uint8_t code) {
    const ItemRange items = run.trial.gaps[run.stack.back().first].items;
    if (run.trial.refused) {
        for (auto& refused : area(run.trial).refused)
            if (model::overlap(refused.items, items)) refused.checked = t;
        run = make_run(t, run.trial);
        return;
    }
    auto& suspicion = suspicion_of(t, run.trial, items);
    if (++suspicion.refused < kRefusals) return;
    give_up(t, run.trial, code, suspicion);
    std::erase_if(suspicions_, [&](const Suspicion& s) { return &s == &suspicion; });
    close(run, false);
}

Learning::Suspicion& Learning::suspicion_of(Instant t, const plan::Trial& trial, const ItemRange& items) {
    const auto found = std::ranges::find_if(suspicions_, [&](const Suspicion& s) {
        return s.device == trial.device && s.read == trial.read && s.items == items;
    });
    if (found != suspicions_.end()) return *found;
    return suspicions_.emplace_back(Suspicion{trial.device, trial.read, items, 0, t});
}

void Learning::give_up(Instant t, const plan::Trial& trial, std::uint8_t code, const Suspicion& suspicion) {
    auto& known = area(trial);
    if (known.refused.size() >= model::Learnt::kMostRanges) return;
    const auto after = std::ranges::upper_bound(known.refused, suspicion.items.first, {},
                                                [](const Refused& r) { return r.items.first; });
    known.refused.insert(after, {suspicion.items, code, suspicion.first, t});
    known.confirmed = model::without(known.confirmed, {suspicion.items});
    changed_ = true;
    add_event(GapEvent::Kind::refused, trial, suspicion.items, code);
}

// Every part was accepted, the whole was not: it is too long. The longest accepted read becomes the limit;
// the gaps are confirmed by the parts.
void Learning::on_whole_refused(Run& run, std::uint8_t code) {
    const Node& node = run.stack.back();
    if (node.refused < kRefusals) return;
    auto& known = area(run.trial);
    const ItemRange items = range_of(run, node);
    known.most_items = std::min(known.longest_taken, static_cast<std::uint16_t>(length_of(items) - 1));
    changed_ = true;
    add_event(GapEvent::Kind::too_long, run.trial, items, code);
    close(run, false);
}

void Learning::on_nothing(Instant t, bool silent) {
    Run& run = runs_[cursor_];
    waiting_ = false;
    last_answer_ = run.since = t;
    run.not_before = after(t, run.silence_backoff.next());
    cursor_ = (cursor_ + 1) % runs_.size();
    const std::size_t top = run.stack.size() - 1;
    auto& node = run.stack[top];
    if (!silent || ++node.silent < kSilences) return;
    if (node.first == node.last) return postpone(t, run);
    node.part_failed = true;
    if (node.split) return close(run, false);
    split(run, top);
}

// A gap that can be neither confirmed nor refused is postponed with a growing back-off; the rest of its trial
// continues.
void Learning::postpone(Instant t, Run& run) {
    const Duration wait =
        run.postponed ? std::min<Duration>(2 * *run.postponed, kLastRecheck) : kFirstPostponement;
    plan::Trial alone{.device = run.trial.device,
                      .read = run.trial.read,
                      .gaps = {run.trial.gaps[run.stack.back().first]},
                      .refused = run.trial.refused};
    Run later = make_run(t, std::move(alone));
    later.not_before = std::max(later.not_before, after(t, wait));
    later.postponed = wait;
    close(run, false);
    runs_.push_back(std::move(later));
    drop_finished();
}

void Learning::drop_finished() {
    std::erase_if(runs_, [](const Run& run) { return run.stack.empty(); });
    if (cursor_ >= runs_.size()) cursor_ = 0;
}

}  // namespace takt::poll
