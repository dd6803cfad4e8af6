// What an outcome means: for the values, for the device, for the statuses.
#include <algorithm>

#include "run.hpp"

namespace takt::poll {

using value::Quality;
using value::Reason;

Verdict verdict_of(const bus::Outcome& outcome) {
    switch (outcome.status) {
        case bus::Status::ok: return {Reason::ok, true};
        case bus::Status::exception: {
            const auto code = wire::ExceptionCode{outcome.exception};
            const bool gateway = code == wire::ExceptionCode::gateway_path_unavailable ||
                                 code == wire::ExceptionCode::gateway_target_failed_to_respond;
            const bool busy =
                code == wire::ExceptionCode::acknowledge || code == wire::ExceptionCode::server_device_busy;
            return {value::exception_reason(outcome.exception), !gateway, busy};
        }
        case bus::Status::bad_checksum: return {Reason::bad_checksum};
        case bus::Status::unexpected_reply: return {Reason::unexpected_reply};
        case bus::Status::link_lost:
        case bus::Status::cancelled: return {Reason::link_lost};
        case bus::Status::timeout:
        case bus::Status::line_busy: break;
    }
    return {Reason::timeout};
}

// Comes before the values of the outcome are looked at: it may change what is to be done about the whole
// device.
Verdict LinePoller::Run::judge(const bus::Outcome& outcome, std::size_t index,
                               bus::TransactionCounters* counters) {
    auto& device = devices_[index];
    device.in_flight = false;
    device.statistics.counters.count(outcome);
    if (counters) counters->count(outcome);
    if (outcome.sent) busy_time_ += engine_.silence() + (outcome.ended_at - outcome.sent_at);
    const Verdict verdict = verdict_of(outcome);
    if (!device.enabled || verdict.reason == Reason::link_lost) return verdict;
    if (verdict.answered) {
        if (device.health.answered()) restart_device(outcome.ended_at, device);
        set_device_state(outcome.ended_at, index, DeviceState::answering);
    } else if (device.health.failed(outcome.ended_at)) {
        ++device.statistics.outages;
        set_device_state(outcome.ended_at, index, DeviceState::not_answering);
        degrade_device(outcome.ended_at, index, Reason::not_answering, true);
        if (device.has_reads) drop_pending(outcome.ended_at, index, Reason::not_answering);
    }
    return verdict;
}

void LinePoller::Run::on_read(const bus::Outcome& outcome, std::size_t index) {
    auto& request = requests_[index];
    auto& read = *request.read;
    const Verdict verdict = judge(outcome, request.device, &request.statistics.counters);
    const Instant t = outcome.ended_at;
    if (verdict.reason == Reason::link_lost) {
        read.triggered = read.triggered || read.by_trigger;
        return;
    }
    if (!devices_[request.device].enabled) return;
    if (!verdict.answered) {
        fail_read(t, request, verdict.reason);
        return;
    }
    read.health.answered();
    if (verdict.busy)
        read.not_before = after(t, read.busy.next());
    else
        read.busy.reset();
    read.time.record(t - outcome.sent_at);
    if (verdict.reason == Reason::ok) {
        take_values(t, request, outcome.response.span());
    } else {
        degrade(t, request.variables, Quality::bad, verdict.reason, false);
    }
    set_status(t, request, verdict.reason);
}

void LinePoller::Run::take_values(Instant t, RequestRun& request, Bytes pdu) {
    const auto& asked = request.read->request;
    const auto response = wire::decode_response(asked, pdu);
    updates_.clear();
    for (const auto v : request.variables) {
        auto& variable = variables_[v];
        const auto value =
            response ? value_in(*response, asked, *variable.model) : std::unexpected(response.error());
        if (!value) {
            updates_.push_back({variable.slot, std::nullopt, Quality::bad, Reason::unexpected_reply});
            continue;
        }
        variable.last_read = *value;
        updates_.push_back({variable.slot, *value});
    }
    store_.apply(t, updates_);
}

void LinePoller::Run::fail_read(Instant t, RequestRun& request, Reason reason) {
    auto& read = *request.read;
    read.health.failed(t);
    if (!devices_[request.device].health.answering()) return;
    if (!read.health.answering()) {
        read.meter.interrupt();
        degrade(t, request.variables, Quality::bad, reason, true);
    } else {
        degrade(t, request.variables, Quality::uncertain, reason, false);
        if (read.by_trigger)
            read.triggered = true;
        else
            read.retry = t;
    }
    set_status(t, request, reason);
}

void LinePoller::Run::degrade(Instant t, std::span<const std::size_t> variables, Quality quality,
                              Reason reason, bool to_default) {
    updates_.clear();
    for (const auto v : variables) {
        const auto& variable = variables_[v];
        const auto& slot = store_[variable.slot];
        if (!variable.model->read || !variable.model->used) continue;
        value::Update update{variable.slot, std::nullopt, quality, reason};
        if (quality == Quality::uncertain && slot.quality != Quality::good) update.quality = slot.quality;
        if (const auto& initial = store_.info(variable.slot).initial;
            to_default && !variable.model->hold_last && !value::is_empty(initial))
            update.value = initial;
        updates_.push_back(update);
    }
    store_.apply(t, updates_);
}

void LinePoller::Run::degrade_device(Instant t, std::size_t index, Reason reason, bool to_default) {
    std::vector<std::size_t> variables;
    for (std::size_t v = 0; v < variables_.size(); ++v)
        if (variables_[v].device == index) variables.push_back(v);
    degrade(t, variables, Quality::bad, reason, to_default);
    for (const auto r : devices_[index].requests) {
        auto& request = requests_[r];
        request.last_reason = reason;
        if (request.read) request.read->meter.interrupt();
        if (request.plan->status) put_status(t, *request.plan->status, reason);
    }
    set_device_status(t, index);
}

void LinePoller::Run::set_status(Instant t, RequestRun& request, Reason reason) {
    request.last_reason = reason;
    if (request.plan->status) put_status(t, *request.plan->status, reason);
    set_device_status(t, request.device);
}

// The first of its requests that is not well speaks for the device.
void LinePoller::Run::set_device_status(Instant t, std::size_t index) {
    const auto& device = devices_[index];
    if (!device.model->status) return;
    Reason reason = Reason::ok;
    for (const auto r : device.requests)
        if (reason == Reason::ok) reason = requests_[r].last_reason;
    put_status(t, *device.model->status, reason);
}

void LinePoller::Run::put_status(Instant t, model::LocalIndex local, Reason reason) {
    const auto slot = slots_.local(local);
    const auto number =
        value::convert(store_.info(slot).type, false, std::int64_t{value::status_code(reason)});
    if (!number) return;  // a local that is no number shows no status
    const value::Update update{slot, *number};
    store_.apply(t, {&update, 1});
}

}  // namespace takt::poll
