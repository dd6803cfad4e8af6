// Outcomes of writes: write_done_exact, write_unknown_bounded, outcome_once.
#include <algorithm>
#include <utility>

#include "line_judge.hpp"

namespace takt::judge {
namespace {

constexpr std::size_t kRefused = 8;
constexpr std::size_t kExecuted = 16;
constexpr std::size_t kDone = 4096;

/// With so few possible values two orders often have the same one.
bool is_small(const model::Variable& variable) {
    return variable.type == DataType::boolean;
}

}  // namespace

bool LineJudge::verified(std::span<const VariableNumber> members) const {
    return std::ranges::any_of(members, [&](VariableNumber v) { return variables_[v].model->verify; });
}

// Repetition is allowed if the write was surely not executed (busy) or is safe to repeat. With other bytes
// around the answer, the master may have missed it.
void LineJudge::settle_writes(const Transaction& transaction, Instant t) {
    if (transaction.purpose == Purpose::before_write) return settle_before(transaction);
    if (transaction.purpose == Purpose::read_back) return settle_read_back(transaction, t);
    if (transaction.purpose != Purpose::write) return;
    const bool busy = transaction.received.answer == Answer::exception && transaction.received.exception == 6;
    const bool open = !transaction.answered() || transaction.received.among_others;
    const bool confirmed = transaction.answered() && transaction.received.answer != Answer::exception;
    // Of a device that was switched off meanwhile the master drops what follows, unless it was on again in
    // time.
    const Instant from = transaction.cut ? kMayBeReadBack : t;
    if (transaction.request) {
        auto& group = requests_[*transaction.request];
        const bool safe = std::ranges::all_of(
            group.members, [&](VariableNumber v) { return variables_[v].model->safe_to_repeat; });
        group.repeat = busy || (open && safe);
        group.open = open;
        if (confirmed && verified(group.members)) group.read_back_since = from;
    }
    for (const auto id : transaction.commands) {
        const auto found = commands_.find(id);
        if (found == commands_.end()) continue;
        Command& command = found->second;
        const model::Variable& model = *variables_[command.variable].model;
        command.repeat = transaction.request ? requests_[*transaction.request].repeat
                                             : busy || (open && model.safe_to_repeat);
        command.waits = command.repeat;
        if (!transaction.request && confirmed && model.verify) command.read_back_since = from;
    }
}

// Nothing was written yet: after a failure the register is read again, or the write follows.
void LineJudge::settle_before(const Transaction& transaction) {
    const bool exception = transaction.received.answer == Answer::exception && !transaction.gateway();
    const bool busy =
        exception && (transaction.received.exception == 5 || transaction.received.exception == 6);
    const bool good = transaction.received.answer == Answer::good;
    const bool again = (!good && !exception) || busy || transaction.unsure() || transaction.cut;
    if (transaction.request) {
        auto& group = requests_[*transaction.request];
        group.modifying = good;
        group.repeat = again;
    }
    for (const auto id : transaction.commands) {
        const auto found = commands_.find(id);
        if (found == commands_.end()) continue;
        found->second.modifying = good;
        found->second.waits = found->second.repeat = again;
    }
}

// A read may be repeated. A different value is written again if all that was changed is safe to repeat. The
// other bits of its register need not be.
void LineJudge::settle_read_back(const Transaction& transaction, Instant t) {
    const bool good = transaction.received.answer == Answer::good;
    const bool maybe_again = !good || transaction.unsure();
    const Instant again_from = transaction.close == Close::none ? t : kMayBeReadBack;
    const auto same = [&](VariableNumber v, const value::Value& wanted) {
        const auto equals = [&](const Words& values) {
            const auto items = items_in(transaction, v, values);
            return items && holds(*variables_[v].model, *items, wanted, true);
        };
        return good &&
               (equals(transaction.received.values) || std::ranges::any_of(transaction.further, equals));
    };
    const auto settle = [&](Command& command, bool safe) {
        command.compared = same(command.variable, command.order.value);
        command.waits = command.repeat = safe && !(command.compared && !maybe_again);
    };
    if (transaction.request) {
        auto& group = requests_[*transaction.request];
        const bool safe = std::ranges::all_of(
            group.changed, [&](VariableNumber v) { return variables_[v].model->safe_to_repeat; });
        if (maybe_again) group.read_back_since = again_from;
        group.repeat = safe;
        for (auto& [id, command] : commands_)
            if (variables_[command.variable].change_group == *transaction.request && command.sends > 0)
                settle(command, safe);
        return;
    }
    for (const auto id : transaction.commands)
        if (const auto found = commands_.find(id); found != commands_.end()) {
            if (maybe_again) found->second.read_back_since = again_from;
            settle(found->second, variables_[found->second.variable].model->safe_to_repeat);
        }
}

// The link was lost between the read and the write of a read-modify-write: it starts again.
void LineJudge::forget_between() {
    for (auto& group : requests_)
        if (std::exchange(group.modifying, false)) group.repeat = true;
    for (auto& [id, command] : commands_)
        if (std::exchange(command.modifying, false)) command.waits = command.repeat = true;
}

// The last order that matches, preferably one with these values.
Transaction* LineJudge::written_by(const sim::DeviceItems& items) {
    Transaction* source = nullptr;
    Transaction* exact = nullptr;
    for (auto& transaction : transactions_) {
        const Asked& asked = transaction.asked;
        const bool fresh = items.broadcast
                               ? transaction.broadcast && !transaction.taken_by.contains(items.unit.value)
                               : asked.unit == items.unit.value && transaction.executed == 0;
        if (!transaction.writes() || !fresh || asked.write_start != items.start ||
            asked.write_area != items.area)
            continue;
        source = &transaction;
        if (std::ranges::equal(asked.values, items.values)) exact = &transaction;
    }
    return exact ? exact : source;
}

void LineJudge::on_write(const sim::DeviceItems& items) {
    Transaction* source = written_by(items);
    const auto device = device_of(items.unit.value);
    if (!source || !device) {
        complain("write_unknown_bounded", items.time, "no more writes executed than were sent",
                 "one at " + std::to_string(items.start));
        return;
    }
    ++source->executed;
    source->taken_by.insert(items.unit.value);
    source->executed_at = items.time;
    constexpr value::CommandId kOfBroadcast = 0;  // no command to this device
    auto alone =
        source->request || source->commands.empty() ? std::nullopt : std::optional(source->commands.front());
    if (source->device != *device) alone = kOfBroadcast;
    for (std::size_t v = devices_[*device].first_variable;
         v < variables_.size() && variables_[v].device == *device; ++v) {
        const model::Variable& model = *variables_[v].model;
        const unsigned start = model.start();
        if (model.area != items.area || start < items.start ||
            start + model.items() > items.start + items.values.size())
            continue;
        const auto part = items.values.subspan(start - items.start, model.items());
        auto& executed = variables_[v].executed;
        executed.push_back({items.time, Words(part.begin(), part.end()), alone});
        shorten(executed, kExecuted);
        // A broadcast writes its own value, which may be equal by chance.
        if (!items.broadcast) check_executed(v, executed.back());
    }
}

// The device confirmed a write that it did not execute. Without `verify` the master believes it.
void LineJudge::note_ignored(Instant t, std::size_t device) {
    const auto found =
        std::find_if(transactions_.rbegin(), transactions_.rend(), [&](const Transaction& each) {
            return each.device == device && each.writes() && !each.ignored && each.executed == 0;
        });
    if (found == transactions_.rend()) return;
    found->ignored = true;
    for (const auto id : found->commands)
        if (const auto command = commands_.find(id); command != commands_.end())
            command->second.ignored = true;
    believe(*found, t);
}

// A write-only variable shows the value that its device confirmed.
void LineJudge::believe(const Transaction& transaction, Instant t) {
    const Asked& asked = transaction.asked;
    for (VariableNumber v = 0; v < variables_.size(); ++v) {
        const model::Variable& model = *variables_[v].model;
        const unsigned start = model.start();
        if (variables_[v].device != transaction.device || model.area != asked.write_area ||
            start < asked.write_start || start + model.items() > asked.write_start + asked.values.size())
            continue;
        const auto part = std::span(asked.values).subspan(start - asked.write_start, model.items());
        variables_[v].believed.push_back({t, Words(part.begin(), part.end())});
        shorten(variables_[v].believed, kExecuted);
    }
}

void LineJudge::check_executed(VariableNumber v, const Executed& executed) {
    const auto& variable = variables_[v];
    const auto of_this_value = [&](const Order& order) {
        return holds(*variable.model, executed.items, order.value, true);
    };
    if (is_small(*variable.model) || std::ranges::any_of(variable.orders, of_this_value)) return;
    const auto found = std::ranges::find_if(variable.refused, [&](const Order& order) {
        return of_this_value(order) && !executed.for_another(order.command);
    });
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

// The bytes show a history in which the last write was executed. See ledger.hpp.
bool LineJudge::falsely_confirmed(Instant t) {
    if (transactions_.empty() || !transactions_.back().writes() || !one_at_a_time()) return false;
    const Transaction& last = transactions_.back();
    for (const ByteVector& pdu : ledger_.candidates(last.asked))
        if (const auto exempt = ledger_.exemption(t, last.start, last.asked, pdu)) {
            ++recoveries_[*exempt];
            return true;
        }
    return false;
}

void LineJudge::on_outcome(Instant t, const value::CommandOutcome& outcome) {
    using value::CommandResult;
    // For the judge further parts may follow a partial reception. The master already has its answer.
    for (Transaction& earlier : transactions_)
        if (!earlier.over && earlier.purpose == Purpose::read_back && earlier.received.answer == Answer::good)
            settle(earlier, earlier.heard_at);
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
    const bool was_executed = std::ranges::any_of(variable.executed, [&](const Executed& executed) {
        return executed.t >= command.t && holds(*variable.model, executed.items, command.order.value, true);
    });
    const bool itself_executed = std::ranges::any_of(variable.executed, [&](const Executed& executed) {
        return executed.t >= command.t && !executed.for_another(outcome.id) &&
               holds(*variable.model, executed.items, command.order.value, true);
    });
    const std::string what = id + ": " + name_of(command.variable) + " = " + text(command.order.value);
    switch (outcome.result) {
        case CommandResult::done:
            if (!was_executed && !command.broadcast &&
                !(command.ignored && (!variable.model->verify || command.compared)) && !falsely_confirmed(t))
                complain("write_done_exact", t, what + " is done: the device has executed it", "it has not");
            if (variable.model->verify && !command.compared)
                complain("write_done_exact", t, what + " is done: it was read back as written", "it was not");
            return;
        case CommandResult::unknown:
            if (command.sends == 0 && !command.carried && !was_executed && !is_small(*variable.model))
                complain("write_unknown_bounded", t, what + " is unknown: it was sent", "it was not");
            return;
        case CommandResult::refused:
        case CommandResult::expired:
        case CommandResult::queue_full: break;
    }
    const bool differs = outcome.reason == value::Reason::differs;
    if (differs && command.compared)
        complain("write_done_exact", t, what + " was read back as written: it is done", "it was refused");
    drop_order(command.variable, outcome.id, !differs);
    const bool ordered_too = std::ranges::any_of(variable.orders, [&](const Order& order) {
        return order.command != outcome.id && equal(order.value, command.order.value);
    });
    if (itself_executed && !ordered_too && !differs && !is_small(*variable.model))
        complain("write_done_exact", t, what + " was refused or expired: it is not executed", "it was");
}

void LineJudge::check_expired(Instant t) {
    if (t <= stood_still_until_ + std::chrono::milliseconds(1)) return;
    for (const auto& [id, command] : commands_)
        if (command.waits && !command.repeat && command.order.expires < t)
            complain("outcome_once", t, "an outcome of command " + std::to_string(id) + " when it expired",
                     "none " + std::to_string((t - command.order.expires).count()) + " ns later");
}

// A command that shares the rate limit of its variable's trigger waits while others use the tokens.
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
        if (transaction.request) return group.plan == requests_[*transaction.request].plan;
        return std::ranges::any_of(transaction.commands, [&](const auto id) {
            const auto found = commands_.find(id);
            return found != commands_.end() &&
                   std::ranges::find(group.members, found->second.variable) != group.members.end();
        });
    };
    for (auto& group : requests_)
        if (admits(group)) group.last_admitted = transaction.start;
}

}  // namespace takt::judge
