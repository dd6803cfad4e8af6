#include "writes/command_queue.hpp"

#include <algorithm>
#include <utility>

#include "takt/base/assert.hpp"

namespace takt::poll {
namespace {

using value::CommandResult;
using value::Reason;

void raise(Execution& execution, Execution to) {
    execution = std::max(execution, to);
}

auto in_write_of(std::size_t group) {
    return [group](const PendingCommand& c) { return c.group == group && !c.progress.queued(); };
}

}  // namespace

template <class Goes, class End>
void CommandQueue::end_those(const Goes& goes, const End& end) {
    for (const auto& command : commands_)
        if (goes(command)) end(command);
    std::erase_if(commands_, goes);
}

std::uint16_t& CommandQueue::waiting_of(std::size_t group) {
    if (group >= waiting_.size()) waiting_.resize(group + 1);
    return waiting_[group];
}

// ---- arrival and outcome

void CommandQueue::add(Instant t, PendingCommand command) {
    TAKT_ASSERT(!full());
    const std::size_t variable = command.variable;
    const value::Value value = command.command.value;
    if (command.group) ++waiting_of(*command.group);
    commands_.push_back(std::move(command));
    supersede(t, variable, value);
}

void CommandQueue::refuse(Instant t, const value::WriteCommand& command, bool rounded, Reason reason) {
    outcomes_.push_back({command.id, command.slot, CommandResult::refused, reason, rounded, t});
}

void CommandQueue::supersede(Instant t, std::size_t variable, const value::Value& value) {
    end_those(
        [&](const auto& c) {
            return c.variable == variable && c.group && c.progress.queued() &&
                   !value::same(c.command.value, value);
        },
        [&](const auto& c) { withdraw(t, c, CommandResult::refused, Reason::superseded); });
}

std::optional<value::CommandOutcome> CommandQueue::take_outcome() {
    if (outcomes_.empty()) return std::nullopt;
    std::optional outcome(std::move(outcomes_.front()));
    outcomes_.pop_front();
    return outcome;
}

// A refused last attempt does not prove that earlier ones did not execute; a value read back does.
void CommandQueue::conclude(Instant t, const PendingCommand& command, CommandResult result, Reason reason) {
    const auto slot = command.command.slot;
    if (result == CommandResult::refused && command.execution == Execution::possible &&
        reason != Reason::differs)
        result = CommandResult::unknown;
    if (result == CommandResult::refused || result == CommandResult::expired) forget_wanted(command);
    value::CommandOutcome outcome{command.command.id, slot, result, reason, command.rounded, t};
    if (reason == Reason::differs) {
        outcome.written = command.command.value;
        outcome.read_back = command.read_back;
    }
    outcomes_.push_back(std::move(outcome));
}

// Later commands must not restore the value of this one.
void CommandQueue::forget_wanted(const PendingCommand& command) {
    for (auto& later : commands_)
        if (later.variable == command.variable && later.before.number == command.want)
            later.before = command.before;
    values_.restore(command.variable, command.want, command.before);
}

// ---- the end of waiting

void CommandQueue::withdraw(Instant t, const PendingCommand& command, CommandResult unsent, Reason reason) {
    if (command.group && command.progress.queued()) --waiting_of(*command.group);
    const bool may_be_sent = command.execution != Execution::not_sent || command.carried;
    conclude(t, command, may_be_sent ? CommandResult::unknown : unsent, reason);
}

Instant CommandQueue::next_expiry() const {
    Instant next = kNever;
    for (const auto& command : commands_)
        if (command.progress.queued()) next = std::min(next, command.command.expires);
    return next;
}

void CommandQueue::expire(Instant t) {
    end_those([t](const auto& c) { return c.progress.queued() && c.command.expires <= t; },
              [&](const auto& c) { withdraw(t, c, CommandResult::expired, Reason::ok); });
}

void CommandQueue::drop_waiting(Instant t, std::size_t device, Reason reason) {
    end_those([device](const auto& c) { return c.progress.queued() && c.device == device; },
              [&](const auto& c) { withdraw(t, c, CommandResult::refused, reason); });
}

bool CommandQueue::drop_read_backs(Instant t, std::size_t device, Reason reason) {
    const auto before = commands_.size();
    end_those([device](const auto& c) { return c.progress.awaits_read_back() && c.device == device; },
              [&](const auto& c) { conclude(t, c, CommandResult::unknown, reason); });
    return commands_.size() < before;
}

void CommandQueue::end_all(Instant t) {
    end_those([](const auto&) { return true; },
              [&](const auto& c) {
                  const bool queued = c.progress.queued();
                  withdraw(t, c, queued ? CommandResult::expired : CommandResult::unknown, Reason::ok);
              });
}

// ---- commands that are written alone

PendingCommand* CommandQueue::find(std::uint64_t order) {
    const auto found = std::ranges::find(commands_, order, &PendingCommand::order);
    return found == commands_.end() ? nullptr : &*found;
}

PendingCommand& CommandQueue::at(std::uint64_t order) {
    auto* const found = find(order);
    TAKT_ASSERT(found != nullptr);
    return *found;
}

bool CommandQueue::retry(Instant t, std::uint64_t order, const OutcomeClass& outcome_class,
                         std::uint16_t attempts) {
    auto& command = at(order);
    auto& alone = command.alone;
    if (!bus::attempts_left(outcome_class.status(), attempts, alone.failures)) return false;
    if (outcome_class.busy) alone.not_before = after(t, alone.busy.next());
    command.progress.end();
    return true;
}

void CommandQueue::finish(Instant t, std::uint64_t order, CommandResult result, Reason reason) {
    end_those([order](const auto& c) { return c.order == order; },
              [&](const auto& c) { conclude(t, c, result, reason); });
}

// ---- commands that are written with their group

bool CommandQueue::waits_for_group(std::size_t variable) const {
    return std::ranges::any_of(commands_, [variable](const auto& c) {
        return c.variable == variable && c.group && c.progress.queued();
    });
}

bool CommandQueue::begun(std::size_t group, std::size_t variable) const {
    return std::ranges::any_of(commands_, [=, goes = in_write_of(group)](const auto& c) {
        return goes(c) && c.variable == variable;
    });
}

void CommandQueue::begin_group(std::size_t group) {
    if (waiting(group) == 0) return;
    for (auto& command : commands_)
        if (command.group == group && command.progress.queued()) command.progress.begin(false);
    waiting_of(group) = 0;
}

void CommandQueue::note_attempt(std::size_t group, Execution execution) {
    for (auto& command : commands_)
        if (in_write_of(group)(command)) raise(command.execution, execution);
}

void CommandQueue::note_read_back(std::size_t variable, const value::Value& differing) {
    for (auto& command : commands_)
        if (!command.progress.queued() && command.variable == variable) command.read_back = differing;
}

void CommandQueue::note_differs(std::size_t group) {
    for (auto& command : commands_) {
        if (!in_write_of(group)(command)) continue;
        raise(command.execution, Execution::possible);
        command.confirmed = value::is_empty(command.read_back);
    }
}

void CommandQueue::refuse_outdated(Instant t, std::size_t group) {
    end_those(
        [&, goes = in_write_of(group)](const auto& c) {
            return goes(c) && !value::same(c.command.value, values_.wanted(c.variable).value);
        },
        [&](const auto& c) {
            if (c.confirmed)
                conclude(t, c, CommandResult::done, Reason::ok);
            else
                conclude(t, c, CommandResult::refused, Reason::superseded);
        });
}

void CommandQueue::requeue_group(Instant t, std::size_t group) {
    refuse_outdated(t, group);
    for (auto& command : commands_) {
        if (!in_write_of(group)(command)) continue;
        command.progress.end();
        ++waiting_of(group);
    }
}

void CommandQueue::finish_group(Instant t, std::size_t group, CommandResult result, Reason reason) {
    end_those(in_write_of(group), [&](const auto& c) {
        const bool kept = reason == Reason::differs && value::is_empty(c.read_back);
        conclude(t, c, kept ? CommandResult::done : result, kept ? Reason::ok : reason);
    });
}

// ---- commands alone whose value a write of a group writes too

void CommandQueue::carry(std::size_t variable, const value::Value& value) {
    for (auto& command : commands_)
        if (command.variable == variable && command.progress.queued() &&
            value::same(command.command.value, value))
            command.carried = true;
}

void CommandQueue::end_carry(std::size_t device, bool sent) {
    for (auto& command : commands_)
        if (command.device == device && std::exchange(command.carried, false) && sent)
            raise(command.execution, Execution::possible);
}

}  // namespace takt::poll
