// request_was_due, order_kept, failed_to_queue.
#include <algorithm>
#include <utility>

#include "line_judge.hpp"

namespace takt::judge {
namespace {

constexpr Duration kTick(1);

Duration deadline_of(const plan::Request& request) {
    return request.deadline.value_or(request.period.value_or(Duration::zero()));
}

bool reads_range_of(const Asked& asked, const plan::Request& request) {
    if (!request.read || asked.read_start != request.start || asked.read_count != request.quantity)
        return false;
    const auto function = static_cast<std::uint8_t>(*request.read);
    return asked.function == (function == 0x17 ? 0x03 : function);
}

}  // namespace

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
    return request.at_once || (release && *release > request.served_until);
}

// A trigger comes first. Where a release is due too, an admission may hold the trigger back: then either may
// have been meant, and the other one may follow. A repetition serves no release.
bool LineJudge::take_due(RequestState& request, Transaction& transaction) {
    const Instant t = transaction.start;
    const bool due = is_due(request, t);
    const bool background = request.plan->period == Duration::zero();
    const bool known = request.edge || request.retry || due || request.spare || background;
    if (!known) return false;
    transaction.purpose = Purpose::polled;
    request.last_start = t;
    if (request.edge) {
        const auto& local = case_.project.locals[*request.plan->read_trigger];
        transaction.purpose = Purpose::triggered;
        const bool held_back = local.admission.has_value();
        transaction.expected = held_back;
        request.spare =
            request.spare || request.retry || due || (held_back && transaction.requests.size() > 1);
        request.edge.reset();
        if (request.spare) request.served_until = t;
    } else if (request.retry && !(due && request.slowed(devices_[transaction.device].model->attempts))) {
        transaction.repeated = true;
        transaction.due_since = request.failed_at;
        request.retry = false;
    } else if (due) {
        if (!request.at_once) transaction.due_since = first_release_after(request, request.served_until);
        request.at_once = request.retry = false;
        request.served_until = t;
    } else if (std::exchange(request.spare, false) && request.plan->read_trigger) {
        transaction.purpose = Purpose::triggered;  // the one before was the polling
        transaction.expected = case_.project.locals[*request.plan->read_trigger].admission.has_value();
    }
    request.judged_until = t;
    return true;
}

// It looks the same as others that are due, and one of those may have been meant.
void LineJudge::may_have_served(const Transaction& transaction) {
    for (const std::size_t r : transaction.requests) {
        RequestState& request = requests_[r];
        request.judged_until = transaction.start;
        request.spare = request.spare || request.edge;
        request.edge.reset();
    }
}

void LineJudge::classify_read(Transaction& transaction) {
    const Asked& asked = transaction.asked;
    const auto& device = devices_[transaction.device];
    for (std::size_t r = 0; r < requests_.size(); ++r)
        if (requests_[r].plan->device == transaction.device && reads_range_of(asked, *requests_[r].plan))
            transaction.requests.push_back(r);
    const auto modifies = [&](const RequestState& group) {
        return group.plan->device == transaction.device && group.plan->read_modify_write &&
               group.plan->start == asked.read_start &&
               (group.ordered || group.repeat || group.modifying || group.spare_write);
    };
    const auto bit_command = [&](const auto& entry) {
        const auto& variable = variables_[entry.second.variable];
        return entry.second.waits && variable.device == transaction.device && !device.model->fc22 &&
               variable.model->type == DataType::boolean && !wire::is_bit_area(variable.model->area) &&
               variable.model->start() == asked.read_start;
    };
    if (asked.function == 3 && asked.read_count == 1 &&
        (std::ranges::any_of(requests_, modifies) || std::ranges::any_of(commands_, bit_command))) {
        transaction.purpose = Purpose::before;
        may_have_served(transaction);
        for (auto& group : requests_) {
            if (!modifies(group)) continue;
            group.modifying = true;
            group.ordered.reset();
            group.lasting = false;
        }
        return;
    }
    if (device.dead() && !transaction.requests.empty()) {
        transaction.purpose = Purpose::probe;
        for (const auto r : transaction.requests) requests_[r].last_start = transaction.start;
        return;
    }
    // Of several that ask the same, first those that must be asked; what may only have been meant before,
    // last.
    const auto likely_first = [&](std::size_t r) {
        const RequestState& request = requests_[r];
        if (request.edge) return 0;
        const auto release = release_before(request, transaction.start);
        const bool released = release && *release > request.served_until;
        return (request.retry || released) && !request.slowed(device.model->attempts) ? 1 : 2;
    };
    std::ranges::stable_sort(transaction.requests, {}, likely_first);
    for (auto& r : transaction.requests)
        if (take_due(requests_[r], transaction)) {
            std::swap(r, transaction.requests.front());
            if (transaction.expected) may_have_served(transaction);
            return;
        }
    // After trouble the master may have taken it for dead, and reads it anew.
    const auto& backoff = device.model->backoff.value_or(case_.project.backoff);
    if (!transaction.requests.empty() && device.clean_from > epoch_ &&
        transaction.start < device.clean_from + 2 * backoff.limit) {
        transaction.purpose = Purpose::probe;
        return;
    }
    transaction.purpose = device.model->gaps == model::Gaps::learn ? Purpose::learning : Purpose::nothing;
    if (transaction.purpose == Purpose::nothing)
        complain("request_was_due", transaction.start, "a request that is due, triggered or repeated",
                 describe(transaction));
}

// Whether what was asked of a device at `since` could have been sent before `t`: it answers, nothing went
// wrong with it that could hold a request back, and nothing of it is under way.
bool LineJudge::sendable(std::size_t index, Instant since, Instant t) const {
    const DeviceState& device = devices_[index];
    if (since >= t || !device.enabled || device.dead() || device.clean_from >= since) return false;
    return std::ranges::none_of(
        transactions_, [&](const Transaction& other) { return !other.over && other.device == index; });
}

void LineJudge::check_commands_first(const Transaction& transaction) {
    const Instant t = transaction.start;
    const auto late = [&](const std::string& what, Instant since) {
        complain(transaction.repeated ? "failed_to_queue" : "order_kept", t,
                 what + ", asked for " + std::to_string((t - since).count()) + " ns ago, before any polling",
                 describe(transaction));
    };
    for (const auto& [id, command] : commands_) {
        const auto& variable = variables_[command.variable];
        const auto& trigger = variable.model->write_trigger;
        if (!command.waits || command.repeat || variable.change_group || command.order.expires <= t ||
            variable.model->admission || (trigger && case_.project.locals[*trigger].admission) ||
            !sendable(variable.device, command.t, t))
            continue;
        return late("command " + std::to_string(id) + " to write " + name_of(command.variable), command.t);
    }
    for (const auto& request : requests_) {
        const plan::Request& planned = *request.plan;
        if (request.edge && !request.held && !case_.project.locals[*planned.read_trigger].admission &&
            sendable(planned.device, *request.edge, t))
            return late("the triggered read from " + std::to_string(planned.start), *request.edge);
        if (request.ordered && !request.repeat && !request.spare_write && !planned.admission &&
            sendable(planned.device, *request.ordered, t) && !group_waits(request))
            return late("the write from " + std::to_string(planned.start), *request.ordered);
    }
}

// With equal deadlines the order is of no account here; rounds by address have one priority for all. What has
// waited beyond its deadline may go before what is more urgent.
void LineJudge::check_priority(const Transaction& transaction) {
    if (line_.order != model::PollOrder::deadline || transaction.requests.empty()) return;
    const RequestState& sent = requests_[transaction.requests.front()];
    const Instant t = transaction.start;
    const bool background = sent.plan->period == Duration::zero();
    const Duration own = deadline_of(*sent.plan);
    if (!background && (!transaction.due_since || t - *transaction.due_since > own)) return;
    for (const auto& other : requests_) {
        const auto release = release_before(other, t - kTick);
        if (&other == &sent || !other.plan->read || other.held || other.retry || other.at_once || !release ||
            *release <= std::max(other.served_until, other.judged_until))
            continue;
        if (!background && deadline_of(*other.plan) >= own) continue;
        if (!sendable(other.plan->device, *release, t)) continue;
        complain(transaction.repeated ? "failed_to_queue" : "order_kept", t,
                 "the read from " + std::to_string(other.plan->start) + " of " +
                     devices_[other.plan->device].model->name + ", due for " +
                     std::to_string((t - *release).count()) + " ns, whose deadline is shorter",
                 describe(transaction));
        return;
    }
}

void LineJudge::on_local(Instant t, model::LocalIndex local, bool before, bool after) {
    for (std::size_t d = 0; d < devices_.size(); ++d) {
        DeviceState& device = devices_[d];
        if (device.model->poll_enable != local || device.enabled == after) continue;
        device.enabled = after;
        device.failures = device.probes = 0;
        note_trouble(device, t);
        Duration all{};
        for (auto& request : requests_) {
            if (request.plan->device != d) continue;
            request.at_once = after;
            request.retry = request.held = false;
            request.failures = 0;
            all += request.plan->bus_time;
        }
        if (after) note_excess({t, all, {}});
        for (auto& transaction : transactions_)
            if (!transaction.over && transaction.device == d) transaction.cut = true;
    }
    if (before || !after) return;
    for (auto& request : requests_) {
        const bool exchanged = request.plan->read_trigger == local && request.plan->write_trigger == local &&
                               request.plan->write == wire::Function::read_write_multiple_registers;
        if (exchanged && !group_waits(request))
            request.spare = true;  // 0x17 reads it too
        else if (request.plan->read_trigger == local && !request.edge)
            request.edge = t;
        if (request.plan->write_trigger != local || request.members.empty()) continue;
        request.ordered = request.ordered.value_or(t);
        request.lasting = true;
    }
}

}  // namespace takt::judge
