// request_was_due, order_kept, failed_to_queue.
#include <algorithm>
#include <utility>

#include "line_judge.hpp"

namespace takt::judge {
namespace {

constexpr Duration kTick(1);
// So long after a failure of a device a late response may still hold its reads back.
constexpr Duration kUntroubled = std::chrono::seconds(1);

Duration deadline_of(const plan::Request& request) {
    return request.deadline.value_or(request.period.value_or(Duration::zero()));
}

bool reads_range_of(const Asked& asked, const plan::Request& request) {
    if (!request.read || asked.read_start != request.start || asked.read_count != request.quantity)
        return false;
    const auto function = static_cast<std::uint8_t>(*request.read);
    return asked.function == (function == 0x17 ? 0x03 : function);
}

/// A read that is sent instead of a planned one because its response has another length. Its range was
/// derived by the planner: a wider one that the project may read, a part, or another planned read.
bool replaces(const Asked& asked, const plan::ReadAlternatives& alternatives) {
    return std::ranges::any_of(alternatives, [&](const plan::ReadAlternative& alternative) {
        return asked.function == static_cast<std::uint8_t>(alternative.read) &&
               asked.read_start == alternative.start && asked.read_count == alternative.quantity;
    });
}

}  // namespace

plan::ReadAlternatives LineJudge::alternatives_to(const plan::Request& request) const {
    const plan::AlternativeReads reads(case_.project, line_, line_.devices[request.device],
                                       plans_.back().requests);
    return reads.of(request);
}

bool LineJudge::may_be_replaced(const plan::Request& request, Instant t) const {
    auto function = static_cast<std::uint8_t>(*request.read);
    if (*request.read == wire::Function::read_write_multiple_registers) function = 0x03;  // is sent alone
    const std::uint8_t unit = line_.devices[request.device].address.value;
    return in_doubt(t, {.unit = unit, .function = function}) || ledger_.may_check(t, unit);
}

std::optional<Instant> LineJudge::release_before(const RequestState& request, Instant t) const {
    const Duration period = request.plan->period.value_or(Duration::zero());
    const Instant first = epoch_ + request.plan->phase;
    if (period <= Duration::zero() || t < first) return std::nullopt;
    return first + (t - first) / period * period;
}

Instant LineJudge::first_release_after(const RequestState& request, Instant t) const {
    const Instant first = epoch_ + request.plan->phase;
    const auto last = release_before(request, t);
    return last ? *last + *request.plan->period : first;
}

bool LineJudge::is_due(const RequestState& request, Instant t) const {
    const auto release = release_before(request, t);
    return request.plan->period == Duration::zero() || request.at_once ||
           (release && *release > request.served_until);
}

bool LineJudge::may_have_answered(std::size_t device) const {
    return std::ranges::any_of(
        transactions_, [&](const Transaction& each) { return each.device == device && each.unsure(); });
}

// A reported purpose that contradicts the judge's own records is a violation.
void LineJudge::take_claim(Transaction& transaction, const Claim& claim) {
    transaction.chosen = claim.t;
    transaction.purpose = claim.sending.purpose;
    transaction.early = claim.sending.early;
    transaction.request = claim.sending.request;
    if (transaction.purpose == Purpose::write || transaction.purpose == Purpose::before_write)
        forget_possible_read_backs(transaction.device);
    if (const auto wrong = doubt(transaction, claim))
        complain("request_was_due", transaction.start, *wrong,
                 describe(transaction) + ", sent as " + std::string(name(transaction.purpose)));
}

// Until a write is read back its device gets no other one. Polling that is overdue may go before the
// read-back.
void LineJudge::forget_possible_read_backs(std::size_t device) {
    for (auto& request : requests_)
        if (request.plan->device == device && request.read_back_since == kMayBeReadBack)
            request.read_back_since.reset();
    for (auto& [id, command] : commands_)
        if (variables_[command.variable].device == device && command.read_back_since == kMayBeReadBack)
            command.read_back_since.reset();
}

std::optional<std::string> LineJudge::doubt(Transaction& transaction, const Claim& claim) {
    if (claim.sending.device != transaction.device) return "a request to the device of the claim";
    if (transaction.request && (*transaction.request >= requests_.size() ||
                                requests_[*transaction.request].plan->device != transaction.device)) {
        transaction.request.reset();
        return "a request of its plan";
    }
    const bool named = transaction.request || claim.sending.command;
    const bool writes = transaction.purpose == Purpose::write;
    if (writes != transaction.writes() || (transaction.purpose != Purpose::trial && !named))
        return "the kind of the claim";
    switch (transaction.purpose) {
        case Purpose::write: take_write(transaction, claim); return std::nullopt;
        case Purpose::before_write: take_before(transaction, claim); return std::nullopt;
        case Purpose::read_back: take_read_back(transaction, claim); return std::nullopt;
        case Purpose::trial:
            ++recoveries_["trial"];
            if (devices_[transaction.device].model->gaps == model::Gaps::learn) return std::nullopt;
            return "no trials on a device that does not learn";
        default: return doubt_read(transaction);
    }
}

std::optional<std::string> LineJudge::doubt_read(Transaction& transaction) {
    const DeviceState& device = devices_[transaction.device];
    if (!transaction.request) return "the range of the claimed request";
    const plan::Request& planned = *requests_[*transaction.request].plan;
    if (!reads_range_of(transaction.asked, planned)) {
        const bool may_replace = planned.read && may_be_replaced(planned, transaction.start);
        if (!may_replace || !replaces(transaction.asked, alternatives_to(planned)))
            return "the range of the claimed request";
        ++recoveries_["read_replaced"];
        transaction.replaces = true;
        const unsigned end = unsigned{transaction.asked.read_start} + transaction.asked.read_count;
        transaction.partial = transaction.asked.read_start > planned.start ||
                              end < unsigned{planned.start} + planned.quantity ||
                              transaction.asked.function != static_cast<std::uint8_t>(*planned.read);
    }
    if (transaction.is_its_read()) devices_[transaction.device].last_read = transaction.start;
    if (transaction.purpose == Purpose::probe) {
        // It serves what is due: after closes the device keeps its periods when it returns.
        auto& served_until = requests_[*transaction.request].served_until;
        served_until = std::max(served_until, transaction.chosen);
        if (device.may_be_dead()) return std::nullopt;
        return "no probe, the device answers";
    }
    if (device.dead())
        complain("dead_costs_probes", transaction.start,
                 "only probes, " + device.model->name + " does not answer", describe(transaction));
    return transaction.purpose == Purpose::trigger ? doubt_triggered(transaction) : doubt_polled(transaction);
}

std::optional<std::string> LineJudge::doubt_triggered(Transaction& transaction) {
    RequestState& request = requests_[*transaction.request];
    const bool again = in_doubt(transaction) || transaction.replaces;  // its response was ambiguous
    if (!again && (!request.edge || *request.edge > transaction.chosen))
        return "a trigger that rose since it was last served";
    transaction.expected = case_.project.locals[*request.plan->read_trigger].admission.has_value();
    request.forget_edges();
    return std::nullopt;
}

std::optional<std::string> LineJudge::doubt_polled(Transaction& transaction) {
    RequestState& request = requests_[*transaction.request];
    const Instant t = transaction.chosen;
    if (transaction.purpose == Purpose::repetition) {
        // A response may be ambiguous while an earlier one is owed: the read is repeated.
        const bool ambiguous = in_doubt(transaction) || transaction.replaces;
        if (!request.retry && !ambiguous) return "an attempt that failed before its repetition";
        transaction.repeated = true;
        if (request.retry) transaction.due_since = request.failed_at;  // else not known
        request.retry = false;
        request.served_until = t;  // with what has become due meanwhile
        return std::nullopt;
    }
    if (!request.plan->period || !is_due(request, t)) return "a request that is due";
    if (!request.at_once && release_before(request, t))
        transaction.due_since = first_release_after(request, request.served_until);
    request.at_once = request.retry = false;
    request.served_until = t;
    return std::nullopt;
}

// Whether a request of the device that was due at `since` could have been sent before `t`: the device
// answers, no fault held it back, and no request of it is in flight.
bool LineJudge::sendable(std::size_t index, Instant since, Instant t) const {
    const DeviceState& device = devices_[index];
    if (since >= t || !device.enabled || device.may_be_dead() || device.clean_from >= since) return false;
    if (in_doubt(t, index)) return false;
    // A broadcast keeps its place behind commands of devices that are held back.
    const bool behind =
        device.model->address == kBroadcast && std::ranges::any_of(commands_, [&](const auto& entry) {
            const std::size_t other = variables_[entry.second.variable].device;
            return entry.second.waits && other != index &&
                   (in_doubt(t, other) || devices_[other].clean_from >= since);
        });
    if (behind) return false;
    return std::ranges::none_of(
        transactions_, [&](const Transaction& other) { return !other.over && other.device == index; });
}

// A written value that must be read back: nothing else is written to it before.
bool LineJudge::compares(std::size_t device) const {
    const auto group = [&](const RequestState& request) {
        return request.plan->device == device && request.read_back_since;
    };
    const auto alone = [&](const auto& entry) {
        return variables_[entry.second.variable].device == device && entry.second.read_back_since;
    };
    return std::ranges::any_of(requests_, group) || std::ranges::any_of(commands_, alone);
}

// A command, trigger or change without a rate limit of its own that is sent for the first time.
bool LineJudge::is_client(const Claim& claim) const {
    if (claim.sending.purpose == Purpose::trigger) {
        if (!claim.sending.request || *claim.sending.request >= requests_.size()) return false;
        const RequestState& request = requests_[*claim.sending.request];
        const auto& trigger = request.plan->read_trigger;
        return trigger && !case_.project.locals[*trigger].admission && !request.trigger_failed;
    }
    if (claim.sending.purpose != Purpose::write && claim.sending.purpose != Purpose::before_write)
        return false;
    if (claim.sending.command) {
        const auto found = commands_.find(*claim.sending.command);
        if (found == commands_.end()) return false;
        // A confirmed write may have been sent again: its confirmation was ambiguous.
        const Command& command = found->second;
        if (command.sends > 0 || command.repeat || command.modifying) return false;
        const auto& trigger = variables_[found->second.variable].model->write_trigger;
        return !trigger || !case_.project.locals[*trigger].admission;
    }
    if (!claim.sending.request || *claim.sending.request >= requests_.size()) return false;
    const RequestState& group = requests_[*claim.sending.request];
    return !group.plan->admission && !group.repeat && !group.modifying;
}

// Whether the line certainly lets an event without a rate limit of its own go before polling.
bool LineJudge::admits_command(Instant t) const {
    const bool writing = std::ranges::any_of(
        transactions_, [](const Transaction& other) { return !other.over && other.event(); });
    const Duration apart = arithmetic_.silence() + line_.request_gap + line_.commands.min_interval;
    return !writing && (written_until_ == Instant::min() || t >= written_until_ + apart);
}

// Polling with a period that waits and could have been sent before `t`.
const LineJudge::RequestState* LineJudge::waiting_poll(Instant t) const {
    for (const auto& request : requests_) {
        const auto release = release_before(request, t - kTick);
        if (!request.plan->read || request.held || request.retry || request.at_once || !release ||
            *release <= request.served_until)
            continue;
        if (sendable(request.plan->device, *release - kUntroubled, t)) return &request;
    }
    return nullptr;
}

// Commands beyond their rate wait until no polling is due.
void LineJudge::check_polling_first(const Transaction& transaction) {
    const Instant t = transaction.chosen;
    if (line_.commands.burst > 1 || client_end_ == Instant::min() ||
        t >= client_end_ + line_.commands.min_interval)
        return;
    if (const auto* poll = waiting_poll(t))
        complain("order_kept", transaction.start,
                 "the read from " + std::to_string(poll->plan->start) + " of " +
                     devices_[poll->plan->device].model->name +
                     ", before a command that follows another by " +
                     std::to_string((t - client_end_).count()) + " ns",
                 describe(transaction));
}

// Of two transactions one may be overdue polling, also with commands waiting.
void LineJudge::check_commands_first(const Transaction& transaction) {
    const Instant t = transaction.chosen;
    if (transaction.request) {
        const plan::Request& polled = *requests_[*transaction.request].plan;
        const auto since = transaction.due_since;  // nothing: of a device that answers again
        if (polled.period > Duration::zero() && (!since || t - *since > deadline_of(polled))) return;
    }
    const auto late = [&](const std::string& what, Instant since) {
        complain(transaction.repeated ? "failed_to_queue" : "order_kept", transaction.start,
                 what + ", asked for " + std::to_string((t - since).count()) + " ns ago, before any polling",
                 describe(transaction));
    };
    for (const auto& [id, command] : commands_) {
        const auto& variable = variables_[command.variable];
        const auto& trigger = variable.model->write_trigger;
        const std::string what = "command " + std::to_string(id) + " to write " + name_of(command.variable);
        if (command.read_back_since && sendable(variable.device, *command.read_back_since, t))
            return late("the reading back of " + what, *command.read_back_since);
        if (!command.waits || command.repeat || variable.change_group || command.order.expires <= t ||
            variable.model->admission || (trigger && case_.project.locals[*trigger].admission) ||
            !admits_command(t) || !sendable(variable.device, command.t, t) || compares(variable.device))
            continue;
        return late(what, command.t);
    }
    for (std::size_t r = 0; r < requests_.size(); ++r) {
        const RequestState& request = requests_[r];
        const plan::Request& planned = *request.plan;
        const std::string from = " from " + std::to_string(planned.start);
        if (request.edge && !request.held && !request.exchanged &&
            !case_.project.locals[*planned.read_trigger].admission && admits_command(t) &&
            sendable(planned.device, *request.edge, t))
            return late("the triggered read" + from, *request.edge);
        if (request.read_back_since && sendable(planned.device, *request.read_back_since, t))
            return late("the reading back of the write" + from, *request.read_back_since);
        const auto asked = request.members.empty() ? std::nullopt : asked_since(r);
        if (asked && !request.repeat && !planned.admission && admits_command(t) &&
            sendable(planned.device, *asked, t) && !group_waits(request) && !compares(planned.device))
            return late("the write" + from, *asked);
    }
}

// The order of requests with equal deadlines is not judged; rounds by address have one common priority. An
// overdue request may precede a more urgent one, and so may a request with a back-off of its own.
void LineJudge::check_priority(const Transaction& transaction) {
    if (line_.order != model::PollOrder::deadline || !transaction.request) return;
    const RequestState& sent = requests_[*transaction.request];
    if (sent.slowed(devices_[transaction.device].model->attempts)) return;
    const Instant t = transaction.chosen;
    const bool background = sent.plan->period == Duration::zero();
    const Duration own = deadline_of(*sent.plan);
    if (!background && (!transaction.due_since || t - *transaction.due_since > own)) return;
    for (const auto& other : requests_) {
        const auto release = release_before(other, t - kTick);
        if (&other == &sent || !other.plan->read || other.held || other.retry || other.at_once || !release ||
            *release <= other.served_until)
            continue;
        if (!background && deadline_of(*other.plan) >= own) continue;
        if (!sendable(other.plan->device, *release, t)) continue;
        complain(transaction.repeated ? "failed_to_queue" : "order_kept", transaction.start,
                 "the read from " + std::to_string(other.plan->start) + " of " +
                     devices_[other.plan->device].model->name + ", due for " +
                     std::to_string((t - *release).count()) + " ns, whose deadline is shorter",
                 describe(transaction));
        return;
    }
}

void LineJudge::on_local(Instant t, model::LocalIndex local, bool before, bool after) {
    settle_answered();
    for (std::size_t d = 0; d < devices_.size(); ++d)
        if (devices_[d].model->poll_enable == local && devices_[d].enabled != after)
            switch_device(t, d, after);
    if (before || !after) return;
    for (auto& request : requests_) {
        const DeviceState& device = devices_[request.plan->device];
        if (!device.enabled) continue;
        const bool writes = request.plan->write_trigger == local && !request.members.empty();
        const bool exchanges = request.plan->write == wire::Function::read_write_multiple_registers;
        if (device.dead() && device.has_reads) {  // dropped at once
            request.may_be_triggered = writes && may_have_answered(request.plan->device);
            continue;
        }
        if (writes) request.triggered_since = request.triggered_since.value_or(t);
        if (request.plan->read_trigger != local) continue;
        if (request.edge) {
            request.next_edge = t;
            continue;
        }
        request.edge = t;
        request.exchanged = writes && exchanges && !group_waits(request);  // it reads too
    }
}

void LineJudge::switch_device(Instant t, std::size_t d, bool on) {
    DeviceState& device = devices_[d];
    device.enabled = on;
    device.answers();
    note_trouble(device, t);
    restart(d, on);
    if (on) note_excess({t, all_once(d), {}});
    for (auto& transaction : transactions_) {
        if (transaction.device != d) continue;
        if (!transaction.over) transaction.cut = true;
        // The master may not have found the answer. To it the transaction is in flight until its deadline.
        const bool in_flight = transaction.over && transaction.unsure() && transaction.deadline >= t;
        if (!on || !in_flight) continue;
        ++device.possible;  // it may fail yet
        if (!transaction.request) continue;
        RequestState& request = requests_[*transaction.request];
        if (transaction.purpose == Purpose::trigger)
            request.edge = request.edge.value_or(transaction.start);
        else
            request.retry = true;
    }
    if (!on) drop_triggered(d);
}

// Triggered writes are dropped with the device; set values stay.
void LineJudge::drop_triggered(std::size_t d) {
    for (auto& request : requests_) {
        if (request.plan->device != d) continue;
        request.forget_edges();
        request.triggered_since.reset();
        request.may_be_triggered = false;
        request.read_back_since.reset();
    }
}

}  // namespace takt::judge
