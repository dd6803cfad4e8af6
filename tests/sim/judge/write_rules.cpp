// write_done_exact, write_unknown_bounded, unsafe_not_repeated, group_whole, outcome_once.
#include <algorithm>
#include <utility>

#include "line_judge.hpp"

namespace takt::judge {
namespace {

constexpr std::size_t kOrders = 64;
constexpr std::size_t kRefused = 8;
constexpr std::size_t kExecuted = 16;
constexpr std::size_t kDone = 4096;

bool is_bit(const model::Variable& variable) {
    return variable.type == DataType::boolean && !wire::is_bit_area(variable.area);
}

/// Of so few values that two orders are easily for the same one.
bool is_small(const model::Variable& variable) {
    return variable.type == DataType::boolean;
}

template <class Container>
void shorten(Container& container, std::size_t most) {
    while (container.size() > most) container.erase(container.begin());
}

}  // namespace

void LineJudge::on_set(Instant t, VariableNumber v, const value::Value& value) {
    auto& variable = variables_[v];
    variable.orders.push_back({value, t, {}});
    shorten(variable.orders, kOrders);
    if (!variable.change_group) return;
    auto& group = requests_[*variable.change_group];
    group.ordered = group.ordered.value_or(t);
    group.lasting = true;
}

void LineJudge::on_command(Instant t, const value::WriteCommand& command, VariableNumber v) {
    auto& variable = variables_[v];
    variable.orders.push_back({command.value, t, command.id});
    shorten(variable.orders, kOrders);
    commands_.emplace(command.id, Command{command, v, t});
    if (variable.change_group && !requests_[*variable.change_group].ordered)
        requests_[*variable.change_group].ordered = t;
}

bool LineJudge::writes_range_of(const Asked& asked, const plan::Request& request) const {
    if (!request.write || !(request.write_on_change || request.write_trigger)) return false;
    const auto function = static_cast<std::uint8_t>(*request.write);
    if (asked.function != function) return false;
    if (function == 0x17)
        return asked.write_start == request.write_start && asked.values.size() == request.write_quantity;
    return asked.write_start == request.start && (asked.masks || asked.values.size() == request.quantity);
}

bool LineJudge::take_group(Transaction& transaction, std::size_t r) {
    auto& group = requests_[r];
    if (!group.ordered && !group.repeat && !group.modifying && !std::exchange(group.spare_write, false))
        return false;
    transaction.group = r;
    transaction.purpose = Purpose::group;
    transaction.expected = group.plan->admission.has_value() && !group.repeat;
    transaction.repeated = group.repeat;
    if (!group.modifying) {  // else what was ordered since the read is written later
        group.ordered.reset();
        group.lasting = false;
    }
    group.repeat = group.modifying = false;
    for (auto& [id, command] : commands_) {
        if (variables_[command.variable].change_group != r || !command.waits) continue;
        command.waits = false;
        ++command.sends;
        transaction.commands.push_back(id);
    }
    check_group(transaction, group);
    return true;
}

// Whether it writes that bit of its register and leaves the others as they were right before.
bool LineJudge::changes_only(const Transaction& transaction, unsigned bit) const {
    const Asked& asked = transaction.asked;
    const unsigned mask = 1U << bit;
    if (asked.masks) return (~asked.and_mask & 0xFFFFU) == mask;
    if (transactions_.empty() || transactions_.back().purpose != Purpose::before ||
        transactions_.back().heard.values.size() != 1 || transactions_.back().device != transaction.device)
        return false;
    return ((transactions_.back().heard.values[0] ^ asked.values.at(0)) & ~mask) == 0;
}

bool LineJudge::take_command(Transaction& transaction) {
    const Asked& asked = transaction.asked;
    for (auto& [id, command] : commands_) {
        const auto& variable = variables_[command.variable];
        const model::Variable& model = *variable.model;
        if (!command.waits || variable.change_group || variable.device != transaction.device ||
            asked.write_area != model.area || asked.write_start != model.start())
            continue;
        Words items = asked.values;
        if (asked.masks) items = {static_cast<std::uint16_t>(asked.or_mask & ~asked.and_mask)};
        if (items.size() != model.items() || !holds(model, items, command.order.value, true)) continue;
        if (is_bit(model) && !changes_only(transaction, model.bit.value_or(0))) continue;
        command.waits = false;
        command.repeat = false;
        ++command.sends;
        transaction.commands.push_back(id);
        transaction.purpose = Purpose::command;
        return true;
    }
    return false;
}

// What was answered well by now, and of which no outcome was told, waits still. The write that was taken for
// it was of something else with the same bytes.
void LineJudge::free_mistaken() {
    for (Transaction& earlier : transactions_) {
        if (earlier.purpose != Purpose::command || !earlier.over || std::exchange(earlier.looked_into, true))
            continue;
        if (earlier.heard.answer != Answer::good && !earlier.doubtful) continue;
        for (const auto id : earlier.commands)
            if (const auto found = commands_.find(id); found != commands_.end()) found->second.waits = true;
    }
}

// What of these bits a write changes: by 0x16 those of its mask, by a read-modify-write those that differ.
std::optional<unsigned> LineJudge::bits_changed(const Transaction& transaction) const {
    if (transaction.asked.masks) return ~transaction.asked.and_mask & 0xFFFFU;
    if (transactions_.empty()) return std::nullopt;
    const Transaction& before = transactions_.back();
    if (before.purpose != Purpose::before || before.device != transaction.device ||
        before.heard.values.size() != 1 || before.asked.read_start != transaction.asked.write_start)
        return std::nullopt;
    return before.heard.values[0] ^ transaction.asked.values.at(0);
}

/// Whether it is this group of those that write bits of the same register.
bool LineJudge::fits_bits(const Transaction& transaction, const RequestState& group) const {
    if (!transaction.asked.masks && !group.plan->read_modify_write) return true;
    unsigned own = 0;
    for (const VariableNumber v : group.members) own |= 1U << variables_[v].model->bit.value_or(0);
    const auto changed = bits_changed(transaction);
    return changed && (*changed & ~own) == 0;
}

// A command that waits elsewhere may so be done.
void LineJudge::note_carried(const Transaction& transaction) {
    const Asked& asked = transaction.asked;
    for (auto& [id, command] : commands_) {
        const auto& variable = variables_[command.variable];
        const model::Variable& model = *variable.model;
        if (asked.masks || variable.device != transaction.device || model.area != asked.write_area ||
            model.start() < asked.write_start ||
            model.start() + model.items() > asked.write_start + asked.values.size())
            continue;
        const auto items = std::span(asked.values).subspan(model.start() - asked.write_start, model.items());
        command.carried = command.carried || holds(model, items, command.order.value, true);
    }
}

void LineJudge::classify_write(Transaction& transaction) {
    note_carried(transaction);
    if (take_command(transaction)) {
        // Its value may have gone out with a group that was asked for too: then the command follows.
        for (auto& group : requests_)
            if (group.plan->device == transaction.device && (group.ordered || group.modifying) &&
                writes_range_of(transaction.asked, *group.plan))
                group.spare_write = transaction.doubtful = true;
        return;
    }
    for (const bool exactly : {true, false})
        for (std::size_t r = 0; r < requests_.size(); ++r) {
            if (requests_[r].plan->device != transaction.device || requests_[r].members.empty()) continue;
            if (exactly && !fits_bits(transaction, requests_[r])) continue;
            if (!writes_range_of(transaction.asked, *requests_[r].plan) || !take_group(transaction, r))
                continue;
            // It changes nothing: it may as well be the write of another group of the register.
            if (requests_[r].plan->read_modify_write && bits_changed(transaction) == 0U)
                requests_[r].spare_write = true;
            return;
        }
    const auto same = [&](const Transaction& other) {
        return other.device == transaction.device && other.asked.pdu == transaction.asked.pdu &&
               other.heard.answer != Answer::good;
    };
    if (std::ranges::any_of(transactions_, same))
        complain("unsafe_not_repeated", transaction.start,
                 "no repetition: it is not known whether it was done", describe(transaction));
    else
        complain("write_done_exact", transaction.start, "only writes that were ordered, with their values",
                 describe(transaction) + ": " + text(std::span(transaction.asked.values)));
}

void LineJudge::check_group(const Transaction& transaction, const RequestState& group) {
    const Asked& asked = transaction.asked;
    std::uint16_t mask = 0;
    for (const VariableNumber v : group.members) {
        const model::Variable& model = *variables_[v].model;
        const auto bit = static_cast<std::uint16_t>(1U << model.bit.value_or(0));
        if (asked.masks) {
            const Words items{asked.or_mask};
            if ((asked.and_mask & bit) == 0) check_written(transaction, v, items);
        } else if (group.plan->read_modify_write) {
            mask |= bit;
        } else {
            const std::size_t offset = model.start() - asked.write_start;
            check_written(transaction, v, std::span(asked.values).subspan(offset, model.items()));
        }
    }
    if (group.plan->read_modify_write) check_kept_bits(transaction, mask);
}

// "The last one set, else the last one read"; a value that is neither is never written.
void LineJudge::check_written(const Transaction& transaction, VariableNumber v,
                              std::span<const std::uint16_t> items) {
    const auto& variable = variables_[v];
    const model::Variable& model = *variable.model;
    std::string expected = "nothing, it was neither set nor read";
    if (!variable.orders.empty()) {
        if (holds(model, items, variable.orders.back().value, true)) return;
        expected = text(variable.orders.back().value) + ", the last one set";
    } else if (variable.read_items) {
        if (holds(model, items, value_of(model, *variable.read_items), true)) return;
        expected = text(value_of(model, *variable.read_items)) + ", the last one read";
    }
    complain("group_whole", transaction.start, name_of(v) + " = " + expected,
             text(value_of(model, items)) + " in the " + describe(transaction));
}

// By 0x16 only these bits change; by a read-modify-write the others are as just read.
void LineJudge::check_kept_bits(const Transaction& transaction, std::uint16_t changed) {
    const Asked& asked = transaction.asked;
    if (asked.masks) {
        if ((~asked.and_mask & ~changed & 0xFFFF) != 0)
            complain("write_done_exact", transaction.start, "no other bits in the mask",
                     describe(transaction));
        return;
    }
    const Transaction* before = transactions_.empty() ? nullptr : &transactions_.back();
    if (!before || before->purpose != Purpose::before || before->heard.values.size() != 1 ||
        before->device != transaction.device || before->asked.read_start != asked.write_start) {
        complain("write_done_exact", transaction.start, "the register read right before it is written back",
                 describe(transaction));
        return;
    }
    const unsigned differ = before->heard.values[0] ^ asked.values.at(0);
    if ((differ & ~unsigned{changed}) != 0)
        complain("write_done_exact", transaction.start,
                 "the other bits as read: " + text(std::span(before->heard.values)),
                 text(std::span(asked.values)));
}

// What may be sent again: what was surely not done (busy), or may be done twice.
void LineJudge::settle_writes(const Transaction& transaction) {
    const bool busy = transaction.heard.answer == Answer::exception && transaction.heard.exception == 6;
    // Where other bytes stand around the answer, the master need not have found it.
    const bool open = !transaction.answered() || transaction.heard.among_others;
    if (transaction.group) {
        auto& group = requests_[*transaction.group];
        group.repeat = busy || (open && std::ranges::all_of(group.members, [&](VariableNumber v) {
                                    return variables_[v].model->safe_to_repeat;
                                }));
        for (const auto id : transaction.commands)
            if (const auto found = commands_.find(id); found != commands_.end())
                found->second.waits = found->second.repeat = group.repeat;
        return;
    }
    for (const auto id : transaction.commands) {
        const auto found = commands_.find(id);
        if (found == commands_.end()) continue;
        Command& command = found->second;
        command.waits = command.repeat = busy || (open && variables_[command.variable].model->safe_to_repeat);
    }
}

void LineJudge::on_write(const sim::DeviceItems& items) {
    Transaction* source = nullptr;
    for (auto& transaction : transactions_) {
        const Asked& asked = transaction.asked;
        if ((asked.writes || asked.masks) && asked.unit == items.unit.value &&
            asked.write_start == items.start && asked.write_area == items.area && transaction.executed == 0)
            source = &transaction;
    }
    const auto device = device_of(items.unit.value);
    if (!source || !device) {
        complain("write_unknown_bounded", items.time, "no more writes executed than were sent",
                 "one at " + std::to_string(items.start));
        return;
    }
    ++source->executed;
    source->executed_at = items.time;
    for (std::size_t v = devices_[*device].first_variable;
         v < variables_.size() && variables_[v].device == *device; ++v) {
        const model::Variable& model = *variables_[v].model;
        const unsigned start = model.start();
        if (model.area != items.area || start < items.start ||
            start + model.items() > items.start + items.values.size())
            continue;
        const auto part = items.values.subspan(start - items.start, model.items());
        auto& executed = variables_[v].executed;
        executed.push_back({items.time, Words(part.begin(), part.end())});
        shorten(executed, kExecuted);
        check_executed(v, executed.back());
    }
}

void LineJudge::check_executed(VariableNumber v, const Executed& executed) {
    const auto& variable = variables_[v];
    const auto of_this_value = [&](const Order& order) {
        return holds(*variable.model, executed.items, order.value, true);
    };
    if (is_small(*variable.model) || std::ranges::any_of(variable.orders, of_this_value)) return;
    const auto found = std::ranges::find_if(variable.refused, of_this_value);
    if (found == variable.refused.end()) return;
    if (variable.read_items && holds(*variable.model, *variable.read_items, found->value, true)) return;
    complain("write_done_exact", executed.t,
             name_of(v) + " is never written with " + text(found->value) + ", which was refused or expired",
             "it was executed");
}

void LineJudge::drop_order(VariableNumber v, value::CommandId id, bool forbidden) {
    auto& variable = variables_[v];
    const auto found = std::ranges::find(variable.orders, std::optional(id), &Order::command);
    if (found == variable.orders.end()) return;
    if (forbidden) variable.refused.push_back(*found);
    shorten(variable.refused, kRefused);
    variable.orders.erase(found);
}

void LineJudge::on_outcome(Instant t, const value::CommandOutcome& outcome) {
    using value::CommandResult;
    const auto found = commands_.find(outcome.id);
    const std::string id = "command " + std::to_string(outcome.id);
    if (found == commands_.end()) {
        complain(
            "outcome_once", t, "one outcome for each accepted command",
            done_.contains(outcome.id) ? "a second one for " + id : "one for " + id + ", which is not known");
        return;
    }
    const Command command = found->second;
    commands_.erase(found);
    done_.insert(outcome.id);
    shorten(done_, kDone);
    const auto& variable = variables_[command.variable];
    if (variable.change_group && command.sends == 0) forget_order(*variable.change_group);
    const bool was_executed = std::ranges::any_of(variable.executed, [&](const Executed& executed) {
        return executed.t >= command.t && holds(*variable.model, executed.items, command.order.value, true);
    });
    const std::string what = id + ": " + name_of(command.variable) + " = " + text(command.order.value);
    switch (outcome.result) {
        case CommandResult::done:
            if (!was_executed)
                complain("write_done_exact", t, what + " is done: the device has executed it", "it has not");
            return;
        case CommandResult::unknown:
            if (command.sends == 0 && !command.carried && !was_executed && !is_small(*variable.model))
                complain("write_unknown_bounded", t, what + " is unknown: it was sent", "it was not");
            return;
        case CommandResult::refused:
        case CommandResult::expired:
        case CommandResult::queue_full: break;
    }
    drop_order(command.variable, outcome.id, true);
    if (was_executed && !is_small(*variable.model))
        complain("write_done_exact", t, what + " was refused or expired: it is not executed", "it was");
}

// A command that is admitted with the trigger of its variable waits as long as others use up its bucket.
bool LineJudge::queues_for_bucket(VariableNumber v, Instant t) const {
    for (const auto& group : requests_)
        if (group.plan->write_trigger && group.plan->admission &&
            std::ranges::find(group.members, v) != group.members.end() && group.last_admitted &&
            t <= *group.last_admitted + group.plan->admission->min_interval +
                     line_.devices[variables_[v].device].response_timeout)
            return true;
    return false;
}

void LineJudge::note_admitted(const Transaction& transaction) {
    const auto admits = [&](const RequestState& group) {
        if (group.plan->device != transaction.device) return false;
        if (transaction.group) return group.plan == requests_[*transaction.group].plan;
        return std::ranges::any_of(transaction.commands, [&](const auto id) {
            const auto found = commands_.find(id);
            return found != commands_.end() &&
                   std::ranges::find(group.members, found->second.variable) != group.members.end();
        });
    };
    for (auto& group : requests_)
        if (admits(group)) group.last_admitted = transaction.start;
}

// A command of the group ended unsent: unless something else asks for it, the group is not written.
void LineJudge::forget_order(std::size_t r) {
    const auto waits = [&](const auto& entry) {
        return entry.second.waits && variables_[entry.second.variable].change_group == r;
    };
    auto& group = requests_[r];
    group.lasting = group.lasting && group.ordered;
    if (!group.lasting && std::ranges::none_of(commands_, waits)) group.ordered.reset();
}

// A group with a member that was neither set nor read waits, and says so.
bool LineJudge::group_waits(const RequestState& group) const {
    const auto unknown = [&](VariableNumber v) {
        return variables_[v].orders.empty() && !variables_[v].read_items;
    };
    if (group.plan->read_modify_write || group.plan->write == wire::Function::mask_write_register)
        return std::ranges::all_of(group.members, unknown);
    return std::ranges::any_of(group.members, unknown);
}

}  // namespace takt::judge
