// The tables of a line, and what changes a whole device: the link, its switch.
#include "run.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"

namespace takt::poll {
namespace {

bus::LineConfig bus_config(const model::Project& project, const plan::LinePlan& plan,
                           const LinePoller::Options& options) {
    return options.bus ? *options.bus : line_config(project, project.lines[plan.line]);
}

bool is_true(const value::Value& value) {
    const auto* on = std::get_if<bool>(&value);
    return on && *on;
}

/// What a polled request is urgent by.
Duration deadline_of(const plan::Request& request) {
    return request.deadline.value_or(request.period.value_or(Duration::zero()));
}

wire::Pdu encoded(const wire::Request& request) {
    const auto pdu = wire::encode(request);
    TAKT_ASSERT(pdu);  // the plan keeps the limits of its functions
    return *pdu;
}

}  // namespace

LinePoller::Run::Run(const model::Project& project, const plan::LinePlan& plan, const ProjectSlots& slots,
                     value::Store& store, const Options& options)
    : project_(project),
      line_(project.lines[plan.line]),
      plan_(plan),
      slots_(slots),
      store_(store),
      observer_(options.observer),
      engine_(bus_config(project, plan, options), options.traffic) {
    add_variables();
    add_requests();
    commands_.reserve(kMaxCommands);
}

void LinePoller::Run::add_variables() {
    for (std::size_t d = 0; d < line_.devices.size(); ++d) {
        const auto& device = line_.devices[d];
        auto& run = devices_.emplace_back();
        run.model = &device;
        run.wait = answer_wait(project_, device);
        run.health = Health(device.attempts);
        run.enabled = !device.poll_enable || is_true(store_[slots_.local(*device.poll_enable)].value);
        run.statistics.state = run.enabled ? DeviceState::link_down : DeviceState::switched_off;
        for (std::size_t v = 0; v < device.variables.size(); ++v) {
            const auto slot = slots_.variable({plan_.line, d, v});
            if (variables_.empty()) first_slot_ = slot.value;
            variables_.push_back({.model = &device.variables[v], .slot = slot, .device = d});
        }
    }
}

void LinePoller::Run::add_requests() {
    for (const auto& planned : plan_.requests) {
        const std::size_t index = requests_.size();
        const auto& device = line_.devices[planned.device];
        auto& run = requests_.emplace_back();
        run.plan = &planned;
        run.device = planned.device;
        for (const auto v : planned.variables)
            run.variables.push_back(slots_.variable({plan_.line, planned.device, v}).value - first_slot_);
        run.statistics.period = planned.period;
        devices_[planned.device].requests.push_back(index);
        if (planned.read && (planned.period || planned.read_trigger)) {
            ReadJob job{.request = read_request(planned)};
            job.pdu = encoded(job.request);
            job.shape = bus::answer_shape(job.pdu.span());
            job.deadline = deadline_of(planned);
            job.polled = planned.period.has_value();
            job.release = PeriodicRelease(planned.period.value_or(Duration::zero()));
            job.meter = PeriodMeter(planned.period.value_or(Duration::zero()));
            job.health = Health(device.attempts);
            run.read = job;
            devices_[planned.device].has_reads = true;
        }
        if (planned.write && (planned.write_on_change || planned.write_trigger)) add_groups(index);
    }
}

void LinePoller::Run::add_groups(std::size_t request) {
    auto& run = requests_[request];
    WriteJob job{.function = *run.plan->write};
    job.shape = {static_cast<std::uint8_t>(job.function), 5};
    run.write = job;
    for (const auto v : run.variables) {
        if (run.plan->write_on_change) variables_[v].change_group = request;
        if (run.plan->write_trigger) variables_[v].trigger_group = request;
    }
}

void LinePoller::Run::restart_device(Instant t, DeviceRun& device) {
    device.health = Health(device.model->attempts);
    for (const auto index : device.requests) {
        auto& request = requests_[index];
        request.last_reason = value::Reason::ok;
        if (!request.read) continue;
        request.read->health = Health(device.model->attempts);
        request.read->release.restart(after(t, request.plan->phase));
        request.read->meter.interrupt();
        request.read->retry.reset();
        request.read->not_before = Instant::min();
    }
}

void LinePoller::Run::set_device_state(Instant t, std::size_t device, DeviceState state) {
    auto& statistics = devices_[device].statistics;
    if (statistics.state == state) return;
    statistics.state = state;
    if (observer_) observer_->on_device_state(t, plan_.line, device, state);
}

void LinePoller::Run::on_link(Instant t, bool up) {
    engine_.on_link(t, up);
    take_outcomes();
    if (up == up_since_.has_value() && up) return;
    up_since_ = up ? std::optional(t) : std::nullopt;
    busy_time_ = Duration::zero();
    cursor_ = 0;
    for (std::size_t d = 0; d < devices_.size(); ++d) {
        if (!devices_[d].enabled) continue;
        if (up) restart_device(t, devices_[d]);
        set_device_state(t, d, up ? DeviceState::unknown : DeviceState::link_down);
        if (!up) degrade_device(t, d, value::Reason::link_lost, true);
    }
}

void LinePoller::Run::switch_device(Instant t, std::size_t index, bool on) {
    auto& device = devices_[index];
    if (device.enabled == on) return;
    device.enabled = on;
    if (on) {
        restart_device(t, device);
        set_device_state(t, index, up_since_ ? DeviceState::unknown : DeviceState::link_down);
        return;
    }
    set_device_state(t, index, DeviceState::switched_off);
    degrade_device(t, index, value::Reason::switched_off, false);
    drop_pending(t, index, value::Reason::switched_off);
}

void LinePoller::Run::on_local(Instant t, model::LocalIndex local, const value::Value& before,
                               const value::Value& after) {
    const bool was_on = is_true(before);
    const bool on = is_true(after);
    for (std::size_t d = 0; d < devices_.size(); ++d)
        if (devices_[d].model->poll_enable == local) switch_device(t, d, on);
    if (was_on || !on) return;
    for (std::size_t r = 0; r < requests_.size(); ++r) {
        auto& request = requests_[r];
        if (!reachable(devices_[request.device])) continue;
        if (request.read && request.plan->read_trigger == local && !request.read->triggered) {
            request.read->triggered = true;
            request.read->order = ++last_order_;
        }
        if (request.write && request.plan->write_trigger == local) {
            ask_group(r);
            request.write->triggered = true;
        }
    }
}

void LinePoller::Run::on_bytes(Instant t, Bytes bytes) {
    engine_.on_bytes(t, bytes);
    take_outcomes();
}

void LinePoller::Run::on_tick(Instant t) {
    engine_.on_tick(t);
    take_outcomes();
    expire_commands(t);
}

void LinePoller::Run::take_outcomes() {
    while (const auto outcome = engine_.take_outcome()) on_outcome(*outcome);
}

}  // namespace takt::poll
