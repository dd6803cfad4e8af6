// Writes: write_done_exact, unsafe_not_repeated, group_whole.
#include <algorithm>
#include <utility>

#include "line_judge.hpp"
#include "takt/value/project_slots.hpp"

namespace takt::judge {
namespace {

constexpr std::size_t kOrders = 64;

bool is_bit(const model::Variable& variable) {
    return variable.type == DataType::boolean && !wire::is_bit_area(variable.area);
}

}  // namespace

void LineJudge::on_set(Instant t, VariableNumber v, const value::Value& value) {
    auto& variable = variables_[v];
    variable.orders.push_back({value, t, {}});
    shorten(variable.orders, kOrders);
    if (!variable.change_group) return;
    auto& group = requests_[*variable.change_group];
    group.set_since = group.set_since.value_or(t);
    if (is_bit(*variable.model)) group.set_bits.insert(v);
}

void LineJudge::on_command(Instant t, const value::WriteCommand& command, VariableNumber v) {
    auto& variable = variables_[v];
    variable.orders.push_back({command.value, t, command.id});
    shorten(variable.orders, kOrders);
    commands_.emplace(command.id, Command{command, v, t});
}

// Since when a group waits: for a change, a trigger or a command.
std::optional<Instant> LineJudge::asked_since(std::size_t r) const {
    const RequestState& group = requests_[r];
    std::optional<Instant> since = group.set_since;
    const auto also = [&](Instant t) { since = std::min(since.value_or(t), t); };
    if (group.triggered_since) also(*group.triggered_since);
    for (const auto& [id, command] : commands_)
        if (command.waits && variables_[command.variable].change_group == r) also(command.t);
    return since;
}

bool LineJudge::writes_range_of(const Asked& asked, const plan::Request& request) const {
    if (!request.write || !(request.write_on_change || request.write_trigger)) return false;
    const auto function = static_cast<std::uint8_t>(*request.write);
    if (asked.function != function) return false;
    if (function == 0x17)
        return asked.write_start == request.write_start && asked.values.size() == request.write_quantity;
    return asked.write_start == request.start && (asked.masks || asked.values.size() == request.quantity);
}

void LineJudge::take_write(Transaction& transaction, const Claim& claim) {
    if (transaction.broadcast) believe(transaction, transaction.start);
    if (!transaction.request) return take_command(transaction, *claim.sending.command);
    if (!writes_range_of(transaction.asked, *requests_[*transaction.request].plan))
        return complain("write_done_exact", transaction.start, "the range of the claimed group",
                        describe(transaction));
    take_group(transaction);
    note_carried(transaction);
}

void LineJudge::take_group(Transaction& transaction) {
    const std::size_t r = *transaction.request;
    auto& group = requests_[r];
    const bool modifies = group.plan->read_modify_write;
    const bool triggered = std::exchange(group.may_be_triggered, false);
    const bool asked = modifies ? group.modifying : asked_since(r) || group.repeat || triggered;
    if (!asked) return complain_of_write(transaction, group.open, group.members);
    transaction.expected = group.plan->admission.has_value() && !group.repeat;
    transaction.repeated = group.repeat;
    take_group_commands(transaction, modifies);
    check_group(transaction, group);
    group.changed = changed_by(transaction, group);
    if (group.exchanged) group.forget_edges();
    group.repeat = group.modifying = group.exchanged = false;
    if (modifies) return;  // later orders are written by the next write
    group.taken_bits = std::exchange(group.set_bits, {});
    check_bits_taken(transaction, group);
    group.set_since.reset();
    group.triggered_since.reset();
}

void LineJudge::take_group_commands(Transaction& transaction, bool were_modifying) {
    for (auto& [id, command] : commands_) {
        if (variables_[command.variable].change_group != *transaction.request) continue;
        if (were_modifying ? !command.modifying : !command.waits) continue;
        if (command.order.expires < transaction.chosen && !were_modifying)
            complain("write_done_exact", transaction.start,
                     "command " + std::to_string(id) + " not sent any more, it has expired",
                     describe(transaction));
        command.waits = command.modifying = false;
        command.broadcast = transaction.broadcast;
        ++command.sends;
        transaction.commands.push_back(id);
    }
}

// A write that may be repeated, after a response that may have been that to an earlier one.
bool LineJudge::repeats_ambiguous(const Transaction& transaction,
                                  std::span<const VariableNumber> written) const {
    return in_doubt(transaction) && !written.empty() && std::ranges::all_of(written, [&](VariableNumber v) {
               return variables_[v].model->safe_to_repeat;
           });
}

void LineJudge::complain_of_write(const Transaction& transaction, bool open,
                                  std::span<const VariableNumber> written) {
    if (repeats_ambiguous(transaction, written)) return;
    if (open)
        complain("unsafe_not_repeated", transaction.start,
                 "no repetition: it is not known whether it was done", describe(transaction));
    else
        complain("write_done_exact", transaction.start, "only writes that were ordered, with their values",
                 describe(transaction) + ": " + text(std::span(transaction.asked.values)));
}

// Whether it writes that bit of its register and keeps the others as just read.
bool LineJudge::changes_only(const Transaction& transaction, unsigned bit) const {
    const Asked& asked = transaction.asked;
    const unsigned mask = 1U << bit;
    if (asked.masks) return (~asked.and_mask & 0xFFFFU) == mask;
    if (transactions_.empty() || transactions_.back().purpose != Purpose::before_write ||
        transactions_.back().received.values.size() != 1 || transactions_.back().device != transaction.device)
        return false;
    return ((transactions_.back().received.values[0] ^ asked.values.at(0)) & ~mask) == 0;
}

bool LineJudge::writes_command(const Transaction& transaction, const Command& command) const {
    const Asked& asked = transaction.asked;
    const auto& variable = variables_[command.variable];
    const model::Variable& model = *variable.model;
    if (variable.change_group || variable.device != transaction.device || asked.write_area != model.area ||
        asked.write_start != model.start())
        return false;
    Words items = asked.values;
    if (asked.masks) items = {static_cast<std::uint16_t>(asked.or_mask & ~asked.and_mask)};
    if (items.size() != model.items() || !holds(model, items, command.order.value, true)) return false;
    return !is_bit(model) || changes_only(transaction, model.bit.value_or(0));
}

void LineJudge::take_command(Transaction& transaction, value::CommandId id) {
    const auto found = commands_.find(id);
    if (found == commands_.end()) return complain_of_write(transaction, false, {});
    Command& command = found->second;
    const bool modifies = modifies_alone(command);
    if (modifies ? !command.modifying : !command.waits)
        return complain_of_write(transaction, command.sends > 0, {&command.variable, 1});
    if (!writes_command(transaction, command)) return complain_of_write(transaction, false, {});
    if (command.order.expires < transaction.chosen && !modifies)
        complain("write_done_exact", transaction.start,
                 "command " + std::to_string(id) + " not sent any more, it has expired",
                 describe(transaction));
    transaction.repeated = command.repeat;
    command.waits = command.modifying = command.repeat = false;
    command.broadcast = transaction.broadcast;
    ++command.sends;
    transaction.commands.push_back(id);
}

bool LineJudge::modifies_alone(const Command& command) const {
    const auto& variable = variables_[command.variable];
    return !variable.change_group && is_bit(*variable.model) && !devices_[variable.device].model->fc22;
}

// The read of a read-modify-write has the same cause as its write.
void LineJudge::take_before(Transaction& transaction, const Claim& claim) {
    const Asked& asked = transaction.asked;
    const auto reads = [&](unsigned start) {
        return asked.function == 3 && asked.read_count == 1 && asked.read_start == start;
    };
    const auto wrong = [&] {
        complain("write_done_exact", transaction.start, "the read of a register that is to be written",
                 describe(transaction));
    };
    if (!transaction.request) {
        const auto found = commands_.find(*claim.sending.command);
        // An ambiguous response to the read is followed by another read.
        const bool again = in_doubt(transaction) && found != commands_.end() && found->second.modifying;
        if (found == commands_.end() || !(found->second.waits || again) || !modifies_alone(found->second) ||
            !reads(variables_[found->second.variable].model->start()))
            return wrong();
        found->second.waits = false;
        found->second.modifying = true;
        transaction.commands.push_back(found->first);
        return;
    }
    auto& group = requests_[*transaction.request];
    if (!group.plan->read_modify_write || !reads(group.plan->start) ||
        !(asked_since(*transaction.request) || group.repeat || (group.modifying && in_doubt(transaction))))
        return wrong();
    transaction.expected = group.plan->admission.has_value() && !group.repeat;
    for (auto& [id, command] : commands_) {
        if (variables_[command.variable].change_group != *transaction.request || !command.waits) continue;
        command.waits = false;
        command.modifying = true;
        transaction.commands.push_back(id);
    }
    group.taken_bits = std::exchange(group.set_bits, {});
    group.modifying = true;
    group.repeat = false;
    group.set_since.reset();
    group.triggered_since.reset();
}

void LineJudge::take_read_back(Transaction& transaction, const Claim& claim) {
    std::optional<Instant>* since = nullptr;
    if (transaction.request) {
        since = &requests_[*transaction.request].read_back_since;
    } else if (const auto found = commands_.find(*claim.sending.command); found != commands_.end()) {
        since = &found->second.read_back_since;
        transaction.commands.push_back(found->first);
    }
    if (in_doubt(transaction) && since && !*since) return;  // it was ambiguous
    if (!since || !*since)
        return complain("request_was_due", transaction.start,
                        "a write that was confirmed and is to be compared", describe(transaction));
    since->reset();
}

// Waiting commands whose value a group wrote as well may end as done.
void LineJudge::note_carried(const Transaction& transaction) {
    const RequestState& group = requests_[*transaction.request];
    for (auto& [id, command] : commands_) {
        if (!command.waits || std::ranges::find(group.members, command.variable) == group.members.end())
            continue;
        const auto& orders = variables_[command.variable].orders;
        const bool wanted = !orders.empty() && equal(orders.back().value, command.order.value);
        command.carried = command.carried || wanted;
    }
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

// All members of a group; of the bits of a register those in the mask. Of a read-modify-write those that were
// ordered since the last attempt, and those that differ from the register as read. A bit that has its value
// already and was ordered before a failed attempt, or is written by a trigger, is not known.
std::set<VariableNumber> LineJudge::changed_by(const Transaction& transaction,
                                               const RequestState& group) const {
    const Asked& asked = transaction.asked;
    std::set<VariableNumber> changed(group.members.begin(), group.members.end());
    if (!asked.masks && !group.plan->read_modify_write) return changed;
    unsigned bits = asked.masks ? ~unsigned{asked.and_mask} : 0U;
    if (!asked.masks && !transactions_.empty() && transactions_.back().received.values.size() == 1) {
        const Transaction& before = transactions_.back();
        const unsigned written = asked.values.at(0);
        bits = before.received.values[0] ^ written;
        for (const Words& read : before.further) bits &= read.at(0) ^ written;
    }
    const auto ordered = [&](VariableNumber v) {
        return group.taken_bits.contains(v) ||
               std::ranges::any_of(transaction.commands, [&](const value::CommandId id) {
                   const auto found = commands_.find(id);
                   return found != commands_.end() && found->second.variable == v;
               });
    };
    std::erase_if(changed, [&](VariableNumber v) {
        const bool differs = (bits >> variables_[v].model->bit.value_or(0) & 1U) != 0;
        return !differs && (asked.masks || !ordered(v));
    });
    return changed;
}

// The written value is the last one set, else the last one read, else the default. Any other value is a
// violation.
void LineJudge::check_written(const Transaction& transaction, VariableNumber v,
                              std::span<const std::uint16_t> items) {
    const auto& variable = variables_[v];
    const model::Variable& model = *variable.model;
    std::string expected = "nothing, it was neither set nor read, and has no default";
    if (!variable.orders.empty()) {
        if (holds(model, items, variable.orders.back().value, true)) return;
        expected = text(variable.orders.back().value) + ", the last one set";
    } else if (variable.read_items) {
        if (holds(model, items, value_of(model, *variable.read_items), true)) return;
        expected = text(value_of(model, *variable.read_items)) + ", the last one read";
    } else if (model.default_value) {
        const auto initial = value::to_value(model.type, model.scaled(), *model.default_value);
        if (holds(model, items, initial, true)) return;
        expected = text(initial) + ", its default";
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
    if (!before || before->purpose != Purpose::before_write || before->received.values.size() != 1 ||
        before->device != transaction.device || before->asked.read_start != asked.write_start) {
        complain("write_done_exact", transaction.start, "the register read right before it is written back",
                 describe(transaction));
        return;
    }
    const auto kept = [&](const Words& read) {
        return ((read.at(0) ^ unsigned{asked.values.at(0)}) & ~unsigned{changed}) == 0;
    };
    if (!kept(before->received.values) && std::ranges::none_of(before->further, kept))
        complain("write_done_exact", transaction.start,
                 "the other bits as read: " + text(std::span(before->received.values)),
                 text(std::span(asked.values)));
}

// A set bit is written with the next write of its group.
void LineJudge::check_bits_taken(const Transaction& transaction, const RequestState& group) {
    for (const VariableNumber v : group.taken_bits) {
        const unsigned bit = 1U << variables_[v].model->bit.value_or(0);
        if (transaction.asked.masks && (transaction.asked.and_mask & bit) != 0)
            complain("group_whole", transaction.start, name_of(v) + ", which was set, in the mask",
                     describe(transaction));
    }
}

// A group with a member that was neither set nor read and has no default waits and reports it.
bool LineJudge::group_waits(const RequestState& group) const {
    const auto unknown = [&](VariableNumber v) {
        const auto& variable = variables_[v];
        return variable.orders.empty() && !variable.read_items && !variable.model->default_value;
    };
    if (group.plan->read_modify_write || group.plan->write == wire::Function::mask_write_register)
        return std::ranges::all_of(group.members, unknown);
    return std::ranges::any_of(group.members, unknown);
}

}  // namespace takt::judge
