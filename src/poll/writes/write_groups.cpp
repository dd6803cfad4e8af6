#include "writes/write_groups.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "takt/plan/request_job.hpp"

namespace takt::poll {

using value::CommandResult;
using value::Reason;

// ---- groups and members

void WriteGroups::add(std::size_t group, WriteGroup added, bool on_change, bool by_trigger) {
    for (const auto v : added.members) {
        if (v >= members_.size()) members_.resize(v + 1);
        if (on_change) members_[v].on_change = static_cast<std::uint32_t>(group);
        if (by_trigger) members_[v].by_trigger = static_cast<std::uint32_t>(group);
    }
    if (group >= groups_.size()) groups_.resize(group + 1);
    groups_[group] = std::make_unique<WriteGroup>(std::move(added));
}

std::optional<std::size_t> WriteGroups::on_change(std::size_t variable) const {
    if (variable >= members_.size() || members_[variable].on_change == kNone) return std::nullopt;
    return members_[variable].on_change;
}

std::optional<std::size_t> WriteGroups::by_trigger(std::size_t variable) const {
    if (variable >= members_.size() || members_[variable].by_trigger == kNone) return std::nullopt;
    return members_[variable].by_trigger;
}

// ---- what asks for a write

void WriteGroups::ask(Instant t, std::size_t group) {
    if (due(group)) return;
    auto& asked = *groups_[group];
    asked.reported_waiting = false;
    asked.failures = 0;
    asked.event.arrive(t, arrivals_.next());
}

void WriteGroups::set(Instant t, std::size_t variable) {
    const auto group = on_change(variable);
    if (!group) return;
    members_[variable].pending = true;
    ask(t, *group);
    groups_[*group]->asked = true;
}

void WriteGroups::pull_trigger(Instant t, std::size_t group) {
    ask(t, group);
    groups_[group]->triggered = true;
}

// ---- the choice

bool WriteGroups::due(std::size_t group) const {
    return groups_[group]->asked || groups_[group]->triggered || commands_.waiting(group) > 0;
}

std::optional<std::size_t> WriteGroups::missing(std::size_t index) {
    const auto& group = *groups_[index];
    if (group.writes_bits()) {
        choose_bits(group);
        return bits_.empty() ? std::optional(group.members.front()) : std::nullopt;
    }
    const auto found = std::ranges::find_if(group.members, [this](auto v) { return !values_.to_write(v); });
    return found != group.members.end() ? std::optional(*found) : std::nullopt;
}

bool WriteGroups::ready(std::size_t group) {
    const auto variable = missing(group);
    if (variable && !std::exchange(groups_[group]->reported_waiting, true))
        waiting_.push_back({group, *variable});
    return !variable;
}

std::optional<WriteGroups::Waiting> WriteGroups::take_waiting() {
    if (waiting_.empty()) return std::nullopt;
    const Waiting first = waiting_.front();
    waiting_.erase(waiting_.begin());
    return first;
}

TokenBucket* WriteGroups::bucket(std::size_t group) {
    auto& bucket = groups_[group]->event.bucket;
    return bucket ? &*bucket : nullptr;
}

bool* WriteGroups::line_token(std::size_t group) {
    return groups_[group]->event.bucket ? nullptr : &groups_[group]->token_taken;
}

// ---- the steps of a write

// By a change: the bits set since the last write. By a trigger: all bits ever set; if there are none, the
// bits as read, else with their defaults. Other bits of the group are not written back: that would undo
// changes made elsewhere.
void WriteGroups::choose_bits(const WriteGroup& group) {
    const auto choose = [&](auto wanted) {
        bits_.clear();
        for (const auto v : group.members)
            if (wanted(v)) bits_.push_back(v);
        return !bits_.empty();
    };
    if (!group.triggered)
        choose([this](std::size_t v) { return members_[v].pending || commands_.waits_for_group(v); });
    else if (!choose([this](std::size_t v) { return values_.was_set(v); }))
        choose([this](std::size_t v) { return values_.to_write(v) != nullptr; });
}

Result<RegisterBits> WriteGroups::bits_of(std::span<const std::size_t> variables) {
    RegisterBits bits;
    for (const auto v : variables) {
        TAKT_TRY(const Written written, values_.encoded(v));
        bits.add(values_.model(v), written.words);
        values_.note_sent(v, written.value);
    }
    return bits;
}

Result<wire::Request> WriteGroups::first_request(const WriteGroup& group) {
    if (group.kind == WriteKind::modify)
        return plan::read_before_write(group.plan->start, group.plan->quantity);
    if (group.kind == WriteKind::mask) {
        TAKT_TRY(const RegisterBits bits, bits_of(group.sending));
        return mask_request(DataAddress{group.plan->start}, bits);
    }
    WrittenItems items(group.function);
    for (const auto v : group.members) {
        TAKT_TRY(const Written written, values_.encoded(v));
        TAKT_CHECK(items.add(values_.model(v), written.words));
        values_.note_sent(v, written.value);
    }
    return group.kind == WriteKind::exchange ? items.exchange(*group.plan) : items.request();
}

// Commands alone with a value that is sent may be executed by this write.
void WriteGroups::carry_values(const WriteGroup& group) {
    for (const auto v : group.written())
        if (const auto* value = values_.to_write(v)) commands_.carry(v, *value);
}

Result<wire::PreparedRequest> WriteGroups::begin(std::size_t index) {
    auto& group = *groups_[index];
    if (group.writes_bits()) {
        choose_bits(group);
        group.sending.assign(bits_.begin(), bits_.end());
        for (const auto v : group.sending)
            members_[v].sent_pending = std::exchange(members_[v].pending, false) || group.triggered;
    }
    const auto request = first_request(group);
    group.sent_asked = group.asked || group.triggered;
    group.sent_triggered = group.sent_triggered || group.triggered;
    group.asked = group.triggered = group.event.admitted = false;
    group.sent_want = values_.last_number();
    commands_.begin_group(index);
    group.progress.begin(group.kind == WriteKind::modify);
    if (!request) return std::unexpected(request.error());
    TAKT_TRY(auto prepared, wire::prepare(*request));
    carry_values(group);
    if (group.read_back) group.read_back->order = group.event.order;
    return prepared;
}

Result<wire::PreparedRequest> WriteGroups::modify(Instant t, std::size_t index, std::uint16_t old) {
    const auto& group = *groups_[index];
    commands_.refuse_outdated(t, index);
    carry_values(group);
    TAKT_TRY(const RegisterBits bits, bits_of(group.sending));
    return wire::prepare(register_request(group.function, DataAddress{group.plan->start}, bits.in(old)));
}

void WriteGroups::await_read_back(std::size_t index) {
    auto& group = *groups_[index];
    group.progress.verify();
    group.read_back->begin(group.read_back->order);
}

bool WriteGroups::read_back_again(Instant t, std::size_t group, const OutcomeClass& outcome_class,
                                  std::uint16_t attempts) {
    return groups_[group]->read_back->again(t, outcome_class, attempts);
}

// ---- the end of a write

bool WriteGroups::retry(Instant t, std::size_t index, const OutcomeClass& outcome_class,
                        std::uint16_t attempts) {
    auto& group = *groups_[index];
    if (!bus::attempts_left(outcome_class.status(), attempts, group.failures)) return false;
    if (outcome_class.busy) group.not_before = after(t, group.busy.next());
    requeue(t, index);
    return true;
}

// Commands whose variable was set to another value meanwhile end as superseded.
void WriteGroups::requeue(Instant t, std::size_t index) {
    auto& group = *groups_[index];
    if (!due(index)) group.event.order = arrivals_.next();
    group.asked = group.asked || group.sent_asked;
    group.event.admitted = true;
    for (const auto v : group.sending) members_[v].pending = members_[v].pending || members_[v].sent_pending;
    commands_.requeue_group(t, index);
    group.progress.end();
}

WriteGroups::Settled WriteGroups::settle(std::size_t index) {
    auto& group = *groups_[index];
    const auto before = std::exchange(group.settled_want, group.sent_want);
    const bool any_set =
        std::ranges::any_of(group.written(), [&](auto v) { return values_.number(v) > before; });
    settled_.clear();
    for (const auto v : group.written()) {
        const auto want = values_.number(v);
        const bool asked = !any_set || (want > before && want <= group.sent_want);
        if (asked && !commands_.begun(index, v)) settled_.push_back(v);
    }
    return {settled_, group.sent_triggered};
}

WriteGroups::Settled WriteGroups::finish(Instant t, std::size_t index, CommandResult result, Reason reason) {
    const auto settled = settle(index);
    auto& group = *groups_[index];
    group.failures = 0;
    group.token_taken = group.sent_triggered = false;
    group.busy.reset();
    group.not_before = Instant::min();
    group.sending.clear();
    group.progress.end();
    commands_.finish_group(t, index, result, reason);
    return settled;
}

// ---- another plan, another poller

std::vector<std::unique_ptr<WriteGroup>> WriteGroups::take_groups() {
    for (auto& member : members_) member.on_change = member.by_trigger = kNone;
    return std::exchange(groups_, {});
}

std::optional<std::size_t> WriteGroups::carry(std::size_t index,
                                              const std::vector<std::unique_ptr<WriteGroup>>& old) {
    auto& group = *groups_[index];
    if (group.members.empty()) return std::nullopt;
    const auto how = [](const WriteGroup& g) {
        return std::tie(g.plan->write_on_change, g.plan->write_trigger);
    };
    const auto found = std::ranges::find_if(old, [&](const auto& other) {
        return other && how(*other) == how(group) &&
               std::ranges::find(other->members, group.members.front()) != other->members.end();
    });
    if (found == old.end()) return std::nullopt;
    const auto& known = **found;
    group.asked = known.asked;
    group.triggered = known.triggered;
    group.event = known.event;
    group.failures = known.failures;
    group.token_taken = known.token_taken;
    group.busy = known.busy;
    group.not_before = known.not_before;
    group.reported_waiting = known.reported_waiting;
    group.sent_want = known.sent_want;
    group.settled_want = known.settled_want;
    return static_cast<std::size_t>(found - old.begin());
}

void WriteGroups::take_over(std::size_t index, const WriteGroup& old, bool same_members) {
    auto& group = *groups_[index];
    group.asked = group.asked || old.asked;
    group.triggered = group.triggered || old.triggered;
    group.failures = old.failures;
    group.busy = old.busy;
    group.not_before = old.not_before;
    group.sent_want = old.sent_want;
    group.settled_want = old.settled_want;
    if (same_members) group.event = old.event;
}

void WriteGroups::take_over_member(std::size_t variable, const WriteGroups& old, std::size_t old_variable) {
    if (variable < members_.size() && old_variable < old.members_.size())
        members_[variable].pending = old.members_[old_variable].pending;
}

}  // namespace takt::poll
