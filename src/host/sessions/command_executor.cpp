// A command that passed its checks has up to two parts to wait for: the write to its device, and the disk
// where the variable is retained. The outcome is delivered when the last part is done. Engines report from
// inside their calls; these reports are queued, and settle() works them off after the call, so that no engine
// is entered twice.
#include "sessions/command_executor.hpp"

#include <utility>
#include <variant>

namespace takt::host {

using value::CommandResult;

void CommandExecutor::execute(Instant t, std::unique_ptr<CommandRequest> command) {
    command->outcome.t = t;
    const auto kind = command->command.kind;
    if (kind == Command::Kind::get) return get(t, std::move(command));
    if (kind == Command::Kind::probe) return probe(t, std::move(command));
    if (const auto& expires = command->command.expires; expires && *expires <= t) {
        command->outcome.result = CommandResult::expired;
        return end(std::move(command));
    }
    if (const auto name = service_name(command->command); !name.empty())
        return refuse(t, std::move(command), fail(Code::read_only, name).error());
    if (persistence_ && persistence_->keeps(command->command.slot) && persistence_->full())
        return refuse(t, std::move(command), fail(Code::queue_full, "retained values").error());
    if (kind == Command::Kind::set) return set(t, std::move(command));
    if (kind == Command::Kind::pull) return pull(t, std::move(command));
    write(t, std::move(command));
}

/// The name of a service variable; empty for anything else.
std::string CommandExecutor::service_name(const Command& command) const {
    if (command.service) return model::ServiceNames(configuration_.project()).name(*command.service);
    const auto& info = configuration_.info(command.slot);
    return info.service ? info.name : std::string();
}

void CommandExecutor::get(Instant t, std::unique_ptr<CommandRequest> command) {
    command->outcome.t = t;
    if (const auto& service = command->command.service) {
        command->outcome.value = surroundings_.service_value(t, *service);
        command->outcome.good_at = command->outcome.sampled_at = t;
        return end(std::move(command));
    }
    const auto& slot = master_.store()[command->command.slot];
    command->outcome.value = slot.value;
    command->outcome.quality = slot.quality;
    command->outcome.reason = slot.reason;
    command->outcome.good_at = slot.good_at;
    command->outcome.sampled_at = slot.sampled_at;
    const auto owner = configuration_.slots().owner(command->command.slot);
    const auto* const index = std::get_if<value::VariableIndex>(&owner);
    if (index && slot.reason == value::Reason::not_answering)
        command->outcome.cause = master_.line(index->line).device(index->device).failure;
    end(std::move(command));
}

void CommandExecutor::probe(Instant t, std::unique_ptr<CommandRequest> command) {
    const auto slot = command->command.slot;
    const auto owner = configuration_.slots().owner(slot);
    const auto* const index = std::get_if<value::VariableIndex>(&owner);
    if (!index || command->command.service)
        return refuse(t, std::move(command), fail(Code::unsupported, configuration_.info(slot).name).error());
    auto& line = master_.line(index->line);
    if (!line.probe_now(t, index->device)) {
        command->outcome.result = CommandResult::refused;
        command->outcome.reason = line.link_up() ? value::Reason::ok : value::Reason::link_lost;
    }
    end(std::move(command));
    surroundings_.on_changed(slot);
}

void CommandExecutor::refuse(Instant t, std::unique_ptr<CommandRequest> command, const Error& error) {
    command->outcome.t = t;
    command->outcome.error = error;
    end(std::move(command));
}

void CommandExecutor::set(Instant t, std::unique_ptr<CommandRequest> command) {
    const auto slot = command->command.slot;
    const auto rounded = master_.set(t, slot, command->command.value);
    if (!rounded) return refuse(t, std::move(command), rounded.error());
    command->outcome.rounded = *rounded;
    const auto waiting = std::make_shared<WaitingSet>();
    waiting->command = std::move(command);
    if (const auto earlier = sets_.extract(slot); !earlier.empty()) {
        earlier.mapped()->command->outcome.progress = Outcome::Progress::superseded;
        part_done(*earlier.mapped());
    }
    if (is_written_soon(slot)) {
        ++waiting->parts;
        waiting->until = after(t, kLongestSet);
        sets_.emplace(slot, waiting);
    } else if (is_written_on_change(slot)) {
        waiting->command->outcome.progress = Outcome::Progress::waiting;
    } else if (configuration_.variable_of(slot) != nullptr) {
        waiting->command->outcome.progress = Outcome::Progress::not_written;
    }
    if (persistence_ && persistence_->keeps(slot)) {
        ++waiting->parts;
        keep(waiting);
    }
    part_done(*waiting);
    surroundings_.on_changed(slot);
}

// It falls first: a local that was left at 1 would not rise.
void CommandExecutor::pull(Instant t, std::unique_ptr<CommandRequest> command) {
    const auto slot = command->command.slot;
    const auto& info = configuration_.info(slot);
    if (!info.local || info.type != DataType::boolean)
        return refuse(t, std::move(command), fail(Code::unsupported, info.name).error());
    for (const bool on : {false, true, false})
        if (const auto done = master_.set(t, slot, on); !done)
            return refuse(t, std::move(command), done.error());
    command->outcome.value = true;
    end(std::move(command));
    surroundings_.on_changed(slot);
}

bool CommandExecutor::is_written_on_change(value::SlotId slot) const {
    const auto* variable = configuration_.variable_of(slot);
    return variable && variable->write_on_change;
}

bool CommandExecutor::is_written_soon(value::SlotId slot) const {
    if (!is_written_on_change(slot)) return false;
    const auto index = std::get<value::VariableIndex>(configuration_.slots().owner(slot));
    const auto state = master_.line(index.line).device(index.device).state;
    return state == poll::DeviceState::answering || state == poll::DeviceState::unknown;
}

void CommandExecutor::write(Instant t, std::unique_ptr<CommandRequest> command) {
    const auto id = command->outcome.id;
    const auto slot = command->command.slot;
    const auto expires = command->command.expires.value_or(after(t, kCommandExpires));
    const auto accepted = master_.write(t, {id, slot, command->command.value, expires});
    if (!accepted) return refuse(t, std::move(command), accepted.error());
    pending_.emplace(id, std::move(command));
    surroundings_.on_changed(slot);
}

Result<bool> CommandExecutor::write(Instant t, value::CommandId id, value::SlotId slot,
                                    const value::Value& value, Written written) {
    const auto accepted = master_.write(t, {id, slot, value, after(t, kEndpointWriteExpires)});
    if (!accepted) return accepted;
    endpoint_writes_.emplace(id, EndpointWrite{value, std::move(written)});
    surroundings_.on_changed(slot);
    return accepted;
}

void CommandExecutor::settle() {
    take_outcomes();
    for (const auto& outcome : settled_) settle_set(outcome);
    settled_.clear();
    give_up_unavailable();
}

void CommandExecutor::take_outcomes() {
    const auto copy = [](const value::CommandOutcome& from, Outcome& to) {
        to.t = from.t;
        to.result = from.result;
        to.reason = from.reason;
        to.rounded = from.rounded;
        to.written = from.written;
        to.read_back = from.read_back;
    };
    while (const auto outcome = master_.take_outcome()) {
        if (auto passed = endpoint_writes_.extract(outcome->id); !passed.empty()) {
            Outcome result{.id = outcome->id,
                           .kind = Command::Kind::write,
                           .slot = outcome->slot,
                           .value = std::move(passed.mapped().value)};
            copy(*outcome, result);
            surroundings_.on_client_write_finished(result);
            passed.mapped().written(*outcome);
            continue;
        }
        auto node = pending_.extract(outcome->id);
        if (node.empty()) continue;
        auto& result = node.mapped()->outcome;
        copy(*outcome, result);
        surroundings_.on_write_finished(result, node.mapped()->session);
        end_when_kept(std::move(node.mapped()));
    }
}

// Of a group of which one member differs, the others were written.
void CommandExecutor::on_group_settled(Instant t, const poll::SettledGroup& group) {
    std::optional<value::SlotId> trigger;
    if (group.trigger) trigger = configuration_.slots().local(*group.trigger);
    for (const auto variable : group.variables) {
        value::CommandOutcome outcome{
            .slot = configuration_.slots().variable({group.line, group.device, variable}),
            .result = group.result,
            .reason = group.reason,
            .t = t};
        const auto differing = differing_.extract(outcome.slot);
        if (group.reason == value::Reason::differs) {
            const bool differs = !differing.empty() && differing.mapped().t == t;
            if (differs) outcome.written = differing.mapped().written;
            if (differs) outcome.read_back = differing.mapped().read_back;
            if (!differs) outcome.result = CommandResult::done;
        }
        if (outcome.result != CommandResult::done || sets_.contains(outcome.slot))
            settled_.push_back({std::move(outcome), trigger});
    }
}

void CommandExecutor::on_verify_failed(Instant t, value::SlotId slot, const value::Value& written,
                                       const value::Value& read) {
    differing_[slot] = {.slot = slot, .t = t, .written = written, .read_back = read};
}

void CommandExecutor::settle_set(const Settled& of_group) {
    const auto& settled = of_group.outcome;
    const auto found = sets_.extract(settled.slot);
    const auto set = found.empty() ? nullptr : found.mapped();
    if (settled.result == CommandResult::done) {
        if (set) part_done(*set);
        return;
    }
    Outcome unwatched;
    Outcome& outcome = set ? set->command->outcome : unwatched;
    const auto& slot = master_.store()[settled.slot];
    outcome.kind = Command::Kind::set;
    outcome.slot = settled.slot;
    outcome.t = settled.t;
    outcome.result = settled.result;
    outcome.reason = settled.reason;
    outcome.written = settled.written;
    outcome.read_back = settled.read_back;
    outcome.value = value::is_empty(slot.wanted) ? slot.value : slot.wanted;
    outcome.trigger = of_group.trigger;
    surroundings_.on_write_finished(outcome, set ? set->command->session : 0);
    if (set) part_done(*set);
}

void CommandExecutor::part_done(WaitingSet& set) {
    if (--set.parts == 0) end(std::move(set.command));
}

void CommandExecutor::end(std::unique_ptr<CommandRequest> command) {
    surroundings_.on_finished(std::move(command));
}

// A retained value is acknowledged when it would survive a kill of the program.
void CommandExecutor::end_when_kept(std::unique_ptr<CommandRequest> command) {
    const auto slot = command->command.slot;
    if (!persistence_ || !persistence_->keeps(slot)) return end(std::move(command));
    const auto waiting = std::make_shared<WaitingSet>();
    waiting->command = std::move(command);
    keep(waiting);
}

// The retention may outlive this object: after abandon_kept() its call finds nothing to do.
void CommandExecutor::keep(const WaitingSetPtr& waiting) {
    kept_->push_back(waiting);
    persistence_->keep(waiting->command->command.slot,
                       [this, waiting, list = std::weak_ptr(kept_)](bool done) {
                           const auto kept = list.lock();
                           if (!kept) return;
                           std::erase(*kept, waiting);
                           waiting->command->outcome.not_retained = !done;
                           part_done(*waiting);
                       });
}

void CommandExecutor::abandon_kept() {
    const auto abandoned = std::exchange(kept_, nullptr);
    for (const auto& waiting : *abandoned) {
        if (!waiting->command) continue;
        waiting->command->outcome.not_retained = true;
        end(std::move(waiting->command));
    }
}

// The value stays set, and is written when it can be.
void CommandExecutor::give_up_sets(const std::function<bool(value::SlotId, const WaitingSet&)>& which) {
    std::vector<WaitingSetPtr> given_up;
    for (const auto& [slot, set] : sets_)
        if (which(slot, *set)) given_up.push_back(set);
    std::erase_if(sets_, [&](const auto& entry) { return which(entry.first, *entry.second); });
    for (const auto& set : given_up) {
        set->command->outcome.progress = Outcome::Progress::waiting;
        part_done(*set);
    }
}

void CommandExecutor::give_up_unavailable() {
    if (sets_.empty()) return unavailable_.clear();  // without an allocation for nothing
    for (const auto& [line, device] : unavailable_)
        give_up_sets([&](value::SlotId slot, const WaitingSet&) {
            const auto index = std::get<value::VariableIndex>(configuration_.slots().owner(slot));
            return index.line == line && index.device == device;
        });
    unavailable_.clear();
}

void CommandExecutor::on_tick(Instant t) {
    if (sets_.empty()) return;
    give_up_sets([t](value::SlotId, const WaitingSet& set) { return set.until <= t; });
}

void CommandExecutor::finish(Instant t) {
    settle();
    give_up_sets([](value::SlotId, const WaitingSet&) { return true; });
    // The pollers have ended every write: nothing should be left.
    for (auto& [id, command] : std::exchange(pending_, {})) {
        command->outcome.t = t;
        command->outcome.result = CommandResult::unknown;
        end(std::move(command));
    }
    endpoint_writes_.clear();
}

}  // namespace takt::host
