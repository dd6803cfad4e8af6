// Sets up the tables of a line, and handles events from outside.
#include "line/run.hpp"

#include <algorithm>

#include "takt/plan/guarantee.hpp"
#include "takt/plan/request_job.hpp"

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

// Clients ask units that the project does not have. These must not take the memory of those that it has.
std::size_t units(const model::Line& line) {
    constexpr std::size_t kOfClients = 32;
    return line.devices.size() + (line.relayed ? kOfClients : 0);
}

// The longest PDU of a line that only reads and does not learn is its longest response. Other lines may send
// any PDU.
std::size_t longest_pdu(const model::Line& line, const plan::LinePlan& plan) {
    if (line.relayed) return wire::kMaxPdu;
    for (const auto& device : line.devices) {
        if (device.gaps == model::Gaps::learn) return wire::kMaxPdu;
        for (const auto& variable : device.variables)
            if (variable.write) return wire::kMaxPdu;
    }
    std::size_t longest = wire::request_pdu_length(wire::Function::read_holding_registers, 1);
    for (const auto& request : plan.requests) {
        if (!request.read || request.write) return wire::kMaxPdu;
        longest = std::max(longest, wire::response_pdu_length(*request.read, request.quantity));
    }
    return longest;
}

WriteKind write_kind(const plan::Request& request) {
    if (request.write == wire::Function::mask_write_register) return WriteKind::mask;
    if (request.write == wire::Function::read_write_multiple_registers) return WriteKind::exchange;
    return request.read_modify_write ? WriteKind::modify : WriteKind::whole;
}

Duration longest_cost(const plan::RequestCosts& costs) {
    if (costs.empty()) return Duration::max();
    return std::chrono::microseconds(
        std::ranges::max(costs, {}, &plan::TransactionCost::transaction).transaction);
}

}  // namespace

LinePoller::Run::Run(const model::Project& project, const plan::LinePlan& plan,
                     const value::ProjectSlots& slots, value::Store& store, const Options& options)
    : project_(project),
      line_(project.lines[plan.line]),
      plan_(&plan),
      slots_(slots),
      store_(store),
      observer_(options.observer),
      engine_buffers_(bus_config(project, plan, options), longest_pdu(project.lines[plan.line], plan),
                      units(project.lines[plan.line])),
      engine_(bus_config(project, plan, options), engine_buffers_.storage(), options.traffic),
      written_values_(store),
      commands_(written_values_, kMaxCommands),
      reads_({variables_, devices_, requests_}, arrivals_),
      write_groups_(written_values_, commands_, arrivals_),
      distinct_reads_(project, line_, {variables_, devices_, requests_}),
      publisher_({variables_, devices_, requests_}, reads_, written_values_, store),
      statuses_({variables_, devices_, requests_}, slots, store),
      periods_({variables_, devices_, requests_}),
      link_(line_.connection),
      proved_ages_(&plan.ages),
      arbiter_(line_.commands.burst, line_.commands.min_interval, line_.order == model::PollOrder::address),
      offers_({.engine = engine_,
               .tables = {variables_, devices_, requests_},
               .reads = reads_,
               .write_groups = write_groups_,
               .commands = commands_,
               .distinct_reads = options.distinct_reads ? &distinct_reads_ : nullptr,
               .arbiter = arbiter_},
              line_.order == model::PollOrder::address) {
    if (options.learn && plan::learns(line_)) begin_learning(plan, options);
    share_line();
    add_variables();
    add_requests();
}

void LinePoller::Run::add_variables() {
    std::size_t count = 0;
    for (const auto& device : line_.devices) count += device.variables.size();
    variables_.reserve(count);
    devices_.reserve(line_.devices.size());
    for (std::size_t d = 0; d < line_.devices.size(); ++d) {
        const auto& device = line_.devices[d];
        auto& run = devices_.emplace_back();
        run.model = &device;
        begin_measuring(run);
        run.most_in_flight =
            static_cast<std::uint16_t>(std::min<std::size_t>(device.in_flight, engine_.config().in_flight));
        run.health = DeviceHealth(device.attempts, plan::backoff_of(project_, device), switched_on(device));
        for (std::size_t v = 0; v < device.variables.size(); ++v) {
            const auto slot = slots_.variable({plan_->line, d, v});
            if (variables_.empty()) first_slot_ = slot.value;
            variables_.push_back(
                {.model = &device.variables[v], .slot = slot, .device = static_cast<std::uint32_t>(d)});
            if (device.variables[v].write)
                written_values_.add(variables_.size() - 1, device.variables[v], slot);
        }
    }
}

bool LinePoller::Run::switched_on(const model::Device& device) const {
    return !device.poll_enable || is_true(store_[slots_.local(*device.poll_enable)].value);
}

std::optional<std::size_t> LinePoller::Run::device_at(UnitId unit) const {
    for (std::size_t d = 0; d < devices_.size(); ++d)
        if (devices_[d].model->address == unit) return d;
    return std::nullopt;
}

void LinePoller::Run::add_requests() {
    arbiter_.set_plan(plan_->utilization, plan_->requests.size());
    requests_.reserve(plan_->requests.size());
    for (const auto& planned : plan_->requests) {
        const std::size_t index = requests_.size();
        auto& run = requests_.emplace_back();
        run.plan = &planned;
        run.device = planned.device;
        for (const auto v : planned.variables)
            run.variables.push_back(slots_.variable({plan_->line, planned.device, v}).value - first_slot_);
        devices_[planned.device].requests.push_back(index);
        const auto job_of = [&](plan::Cause cause) { return plan::job_of(project_, line_, planned, cause); };
        const auto polled = job_of(plan::Cause::period);
        const auto triggered = job_of(plan::Cause::read_trigger);
        if (polled || triggered) add_read(index, polled, triggered);
        if (const auto write = job_of(plan::Cause::write)) add_write(index, *write);
    }
    offers_.set_requests();
    publisher_.set_requests();
    distinct_reads_.set_requests(plan_->requests);
    make_ages();
    statuses_.set_requests();
    periods_.set_requests();
}

void LinePoller::Run::add_read(std::size_t index, const std::optional<plan::RequestJob>& polled,
                               const std::optional<plan::RequestJob>& triggered) {
    auto& run = requests_[index];
    auto& device = devices_[run.device];
    ReadJob job{.request = prepared(plan::planned_read(*run.plan))};
    job.polled = polled.has_value();
    const Duration period = polled ? polled->period : Duration::zero();
    if (polled) job.deadline = polled->deadline.value_or(period);
    job.rank = 2 * index;
    run.read = job;
    run.read_cost = longest_cost(polled ? polled->costs : triggered->costs);
    std::optional<RateLimitedEvent> trigger;
    if (triggered) {
        trigger.emplace(triggered->admission);
        trigger->deadline = triggered->deadline;
    }
    reads_.add(index, period, trigger);
    device.health.set_reads(true);
}

void LinePoller::Run::add_write(std::size_t index, const plan::RequestJob& planned) {
    auto& run = requests_[index];
    run.write_cost = longest_cost(planned.costs);
    const auto& request = *run.plan;
    WriteGroup job{.plan = &request, .function = *request.write, .kind = write_kind(request)};
    if (planned.read_back) job.read_back = std::make_unique<ReadBack>(prepared(*planned.read_back));
    for (const auto v : planned.members)
        job.members.push_back(slots_.variable({plan_->line, run.device, v}).value - first_slot_);
    job.shape = {static_cast<std::uint8_t>(planned.function), planned.response_length};
    job.event = RateLimitedEvent(planned.admission);
    job.event.deadline = planned.deadline;
    job.rank = 2 * index + 1;
    write_groups_.add(index, std::move(job), request.write_on_change, request.write_trigger.has_value());
}

void LinePoller::Run::on_local(Instant t, model::LocalIndex local, const value::Value& before,
                               const value::Value& after) {
    const bool was_on = is_true(before);
    const bool on = is_true(after);
    for (std::size_t d = 0; d < devices_.size(); ++d)
        if (devices_[d].model->poll_enable == local) switch_device(t, d, on);
    if (was_on || !on) return;
    reads_.next_change();
    for (std::size_t r = 0; r < requests_.size(); ++r)
        if (reachable(devices_[requests_[r].device]))
            pull_trigger(t, r, local);
        else
            refuse_trigger(t, r, local);
}

void LinePoller::Run::refuse_trigger(Instant t, std::size_t index, model::LocalIndex local) {
    const auto& request = requests_[index];
    const bool writes = write_groups_.has(index) && request.plan->write_trigger == local;
    if (!writes && !(request.read && request.plan->read_trigger == local)) return;
    const value::Reason reason = devices_[request.device].health.unreachable(link_.no_link());
    for (const auto v : request.variables) statuses_.show_unavailable(t, v, reason);
}

// If a 0x17 must wait for values to write, its read half is sent alone.
void LinePoller::Run::pull_trigger(Instant t, std::size_t index, model::LocalIndex local) {
    const auto& request = requests_[index];
    bool reads = request.read && request.plan->read_trigger == local;
    if (write_groups_.has(index) && request.plan->write_trigger == local) {
        write_groups_.pull_trigger(t, index);
        offers_.note_event(index);
        if (write_groups_[index].kind == WriteKind::exchange && write_groups_.ready(index)) reads = false;
        report_waiting_writes(t);
    }
    if (!reads) return;
    reads_.pull_trigger(t, index);
    offers_.note_event(index);
}

void LinePoller::Run::on_bytes(Instant t, Bytes bytes) {
    link_.received(t);
    engine_.on_bytes(t, bytes);
    take_outcomes();
}

void LinePoller::Run::on_tick(Instant t) {
    if (const Instant due = next_wakeup(); due <= t) exchange_times_.on_wakeup(t - due);
    engine_.on_tick(t);
    take_outcomes();
    settle_held(t);
    commands_.expire(t);
    expire_ages(t);
    report_overruns(t);
}

void LinePoller::Run::take_outcomes() {
    while (const auto late = engine_.take_late()) on_late(*late);
    while (const auto frame = engine_.take_surplus()) on_surplus(*frame);
    while (const auto outcome = engine_.take_outcome()) on_outcome(*outcome);
}

}  // namespace takt::poll
