#include "takt/poll/master.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "takt/value/codec.hpp"

namespace takt::poll {

Master::Master(const model::Project& project, const plan::Plan& plan, const Options& options)
    : slots_(project), store_(value::slot_infos(project)) {
    restore(project, options);
    for (std::size_t i = 0; i < plan.lines.size(); ++i) {
        LinePoller::Options line{.traffic = options.traffic,
                                 .observer = options.observer,
                                 .learn = options.learn,
                                 .distinct_reads = options.distinct_reads,
                                 .plan_maker = options.plan_maker};
        if (i < options.line_traffic.size()) line.traffic = options.line_traffic[i];
        if (i < options.line_bus.size()) line.bus = options.line_bus[i];
        lines_.push_back(std::make_unique<LinePoller>(project, plan.lines[i], slots_, store_, line));
    }
    every_line_.resize(lines_.size());
    std::iota(every_line_.begin(), every_line_.end(), std::size_t{0});
    note_locals(project);
}

void Master::note_locals(const model::Project& project) {
    of_local_.resize(project.locals.size());
    for (std::size_t l = 0; l < lines_.size(); ++l) {
        const auto note = [&](const std::optional<model::LocalIndex>& local) {
            if (local && (of_local_[*local].empty() || of_local_[*local].back() != l))
                of_local_[*local].push_back(l);
        };
        for (const auto& device : project.lines[l].devices) {
            note(device.poll_enable);
            for (const auto& variable : device.variables) {
                note(variable.read_trigger);
                note(variable.write_trigger);
            }
        }
    }
}

std::span<const std::size_t> Master::concerned(value::SlotId slot) const {
    const auto owner = slots_.owner(slot);
    if (const auto* local = std::get_if<model::LocalIndex>(&owner)) return of_local_[*local];
    return std::span(every_line_).subspan(std::get<value::VariableIndex>(owner).line, 1);
}

Master::Master(const model::Project& project, const plan::Plan& plan) : Master(project, plan, Options{}) {}

// Before the lines are made: whether a device is switched on is asked there.
void Master::restore(const model::Project& project, const Options& options) {
    std::vector<value::Update> updates;
    for (const auto& [slot, value, wanted] : options.restored) {
        const auto& info = store_.info(slot);
        const auto quality = info.local ? value::Quality::good : value::Quality::uncertain;
        restored_.insert(slot);
        if (!value::is_empty(value) && value::convert(info.type, info.scaled, value))
            updates.push_back({slot, value, quality, value::Reason::ok});
        const auto owner = slots_.owner(slot);
        const auto* index = std::get_if<value::VariableIndex>(&owner);
        if (!index || value::is_empty(wanted)) continue;
        const auto& variable = project.lines[index->line].devices[index->device].variables[index->variable];
        if (variable.write && value::encode(value::layout_of(variable), wanted)) store_.want(slot, wanted);
    }
    if (!updates.empty()) store_.apply(options.restored_at, updates);
}

Result<bool> Master::set(Instant t, value::SlotId slot, const value::Value& value) {
    const auto owner = slots_.owner(slot);
    if (const auto* local = std::get_if<model::LocalIndex>(&owner)) return set_local(t, *local, value);
    return lines_[std::get<value::VariableIndex>(owner).line]->set(t, slot, value);
}

Result<bool> Master::set_local(Instant t, model::LocalIndex local, const value::Value& value) {
    const auto slot = slots_.local(local);
    TAKT_TRY(const value::Value after, value::convert(store_.info(slot).type, false, value));
    const value::Value before = store_[slot].value;
    const value::Update update{slot, after};
    store_.apply(t, {&update, 1});
    for (const auto line : of_local_[local]) lines_[line]->on_local(t, local, before, after);
    return false;
}

Result<bool> Master::write(Instant t, const value::WriteCommand& command) {
    const auto owner = slots_.owner(command.slot);
    if (const auto* variable = std::get_if<value::VariableIndex>(&owner)) {
        TAKT_TRY(const bool rounded, lines_[variable->line]->write(t, command));
        const auto awaited = std::ranges::find(awaited_, variable->line, &Awaited::line);
        if (awaited == awaited_.end())
            awaited_.push_back({variable->line, 1});
        else
            ++awaited->commands;
        return rounded;
    }
    TAKT_TRY(const bool rounded, set_local(t, std::get<model::LocalIndex>(owner), command.value));
    local_outcomes_.push_back({.id = command.id, .slot = command.slot, .t = t});
    return rounded;
}

std::set<value::SlotId> Master::take_over_values(const Master& old) {
    for (std::uint32_t i = 0; i < store_.size(); ++i) {
        const auto& info = store_.info({i});
        const auto before = old.store_.find(info.name);
        if (!before) continue;
        const auto& known = old.store_.info(*before);
        if (known.type != info.type || known.scaled != info.scaled || known.local != info.local) continue;
        const auto& slot = old.store_[*before];
        const bool has_value = slot.good_at || !value::is_empty(slot.wanted);
        if (!has_value && restored_.contains({i})) continue;
        restored_.erase({i});
        store_.carry_over({i}, slot);
    }
    return std::exchange(restored_, {});
}

std::optional<value::CommandOutcome> Master::take_outcome() {
    if (!local_outcomes_.empty()) {
        auto outcome = std::move(local_outcomes_.front());
        local_outcomes_.pop_front();
        return outcome;
    }
    for (auto awaited = awaited_.begin(); awaited != awaited_.end(); ++awaited) {
        const auto outcome = lines_[awaited->line]->take_outcome();
        if (!outcome) continue;
        if (--awaited->commands == 0) awaited_.erase(awaited);
        return outcome;
    }
    return std::nullopt;
}

}  // namespace takt::poll
