#include "takt/poll/line_poller.hpp"

#include <algorithm>
#include <utility>

#include "line/run.hpp"
#include "takt/base/assert.hpp"

namespace takt::poll {

std::string_view name(DeviceState state) {
    switch (state) {
        case DeviceState::unknown: return "unknown";
        case DeviceState::answering: return "answering";
        case DeviceState::not_answering: return "not_answering";
        case DeviceState::switched_off: return "switched_off";
        case DeviceState::link_down: return "link_down";
    }
    return "unknown";
}

std::string_view name(Purpose purpose) {
    switch (purpose) {
        case Purpose::period: return "period";
        case Purpose::trigger: return "trigger";
        case Purpose::repetition: return "repetition";
        case Purpose::probe: return "probe";
        case Purpose::trial: return "trial";
        case Purpose::write: return "write";
        case Purpose::before_write: return "before_write";
        case Purpose::read_back: return "read_back";
    }
    return "period";
}

LinePoller::LinePoller(const model::Project& project, const plan::LinePlan& plan,
                       const value::ProjectSlots& slots, value::Store& store, const Options& options)
    : run_(std::make_unique<Run>(project, plan, slots, store, options)) {}

LinePoller::LinePoller(const model::Project& project, const plan::LinePlan& plan,
                       const value::ProjectSlots& slots, value::Store& store)
    : LinePoller(project, plan, slots, store, Options{}) {}

LinePoller::~LinePoller() = default;

void LinePoller::on_link(Instant t, bool up) {
    run_->on_link(t, up);
}
void LinePoller::on_close(Instant t) {
    run_->on_close(t);
}
std::optional<Instant> LinePoller::opens_at() const {
    return run_->link_.opens_at();
}
void LinePoller::on_bytes(Instant t, Bytes bytes) {
    run_->on_bytes(t, bytes);
}
void LinePoller::on_tick(Instant t) {
    run_->on_tick(t);
}
Bytes LinePoller::transmit(Instant t) {
    return run_->transmit(t);
}
Instant LinePoller::next_wakeup() const {
    return run_->next_wakeup();
}
std::optional<Error> LinePoller::rejection() const {
    return run_->rejection();
}
bool LinePoller::must_reconnect() const {
    return run_->must_reconnect();
}

Result<bool> LinePoller::set(Instant t, value::SlotId slot, const value::Value& value) {
    return run_->set(t, slot, value);
}
Result<bool> LinePoller::write(Instant t, const value::WriteCommand& command) {
    return run_->write(t, command);
}

std::optional<value::CommandOutcome> LinePoller::take_outcome() {
    return run_->commands_.take_outcome();
}

Result<void> LinePoller::relay(Instant t, const bus::Transaction& transaction, bool spare) {
    return run_->relay(t, transaction, spare);
}
bool LinePoller::was_up() const {
    return run_->link_.was_up();
}

bool LinePoller::link_up() const {
    return run_->link_.usable();
}
bool LinePoller::can_relay() const {
    return run_->relay_ && run_->relay_->empty() && link_up();
}

bool LinePoller::may_start_relayed(Instant t, UnitId unit, const bus::AnswerShape& shape) const {
    return run_->engine_.ambiguity(t, unit, shape) != bus::Ambiguity::held;
}

std::optional<bus::Outcome> LinePoller::take_relayed() {
    return run_->relay_ ? run_->relay_->take_outcome() : std::nullopt;
}

bool LinePoller::withdraw_relayed() {
    return run_->relay_ && run_->relay_->withdraw();
}

void LinePoller::on_local(Instant t, model::LocalIndex local, const value::Value& before,
                          const value::Value& after) {
    run_->on_local(t, local, before, after);
}

// As the plan counts it: each request of the longest round once, with the silence before it, stretched to the
// gap of the line.
LineStatistics LinePoller::statistics(Instant t) const {
    LineStatistics statistics{.counters = run_->engine_.counters(), .planned_cycle = run_->plan_->cycle};
    const auto& config = run_->engine_.config();
    const Duration silence = run_->engine_.silence();
    statistics.availability = run_->availability_;
    const bool answered = statistics.counters.time.count() > 0;
    for (const auto index : run_->plan_->longest_round) {
        const auto& time = run_->requests_[index].traffic.attempt_time;
        if (answered && time.count() > 0)
            statistics.measured_cycle += std::max(time.mean() + silence, config.request_gap);
    }
    const auto up_since = run_->link_.up_since();
    if (up_since && t > *up_since)
        statistics.utilization =
            static_cast<double>(run_->load_.busy().count()) / static_cast<double>((t - *up_since).count());
    if (up_since) statistics.recent_utilization = run_->load_.at(t);
    return statistics;
}

DeviceStatistics LinePoller::device(std::size_t device) const {
    TAKT_ASSERT(device < run_->devices_.size());
    const auto& run = run_->devices_[device];
    DeviceStatistics statistics{run.health.condition(), run.statistics, run.delay_learner.finding(),
                                run.noise_meter.finding()};
    if (statistics.state == DeviceState::not_answering && run.health.probed()) {
        statistics.next_probe = run.health.probe_at();
        statistics.back_off = run.health.probe_wait();
    }
    return statistics;
}

bool LinePoller::probe_now(Instant t, std::size_t device) {
    TAKT_ASSERT(device < run_->devices_.size());
    return link_up() && run_->devices_[device].health.probe_now(t);
}

void LinePoller::admit_guests() {
    run_->admit_guests();
}

HistogramSnapshot LinePoller::request_times(std::size_t request) const {
    TAKT_ASSERT(request < run_->requests_.size());
    return snapshot_of(run_->requests_[request].traffic.times);
}

LineTimes LinePoller::line_times() const {
    return run_->exchange_times_.times();
}

RequestStatistics LinePoller::request(std::size_t request) const {
    TAKT_ASSERT(request < run_->requests_.size());
    const auto& run = run_->requests_[request];
    const auto& traffic = run.traffic;
    RequestStatistics statistics{.counters = traffic.counters, .period = run.plan->period};
    statistics.over_cost = traffic.over_cost;
    statistics.late_refreshes = traffic.late_refreshes;
    if (run.read) {
        statistics.skipped = run_->reads_.skipped(request);
        const auto& meter = run_->periods_.request(request);
        statistics.real_period = meter.real();
        statistics.recent_period = meter.recent();
        statistics.overrun = meter.is_late();
    }
    return statistics;
}

VariableStatistics LinePoller::variable(std::size_t device, std::size_t variable) const {
    const auto slot = run_->slots_.variable({run_->plan_->line, device, variable});
    const auto index = slot.value - run_->first_slot_;
    const auto& meter = run_->periods_.variable(index);
    return {run_->variables_[index].model->period, meter.real(), meter.recent(), meter.is_late()};
}

void LinePoller::replace_plan(plan::LearningPlan plan) {
    if (run_->learner_) run_->learner_->offer(std::move(plan));
}

void LinePoller::hold() {
    run_->hold();
}
bool LinePoller::quiet() const {
    return run_->quiet();
}
bool LinePoller::idle() const {
    return run_->idle();
}
void LinePoller::end_writes(Instant t) {
    run_->end_writes(t);
}
void LinePoller::take_over(Instant t, LinePoller& old) {
    run_->take_over(t, *old.run_);
}

bool LinePoller::learns() const {
    return run_->learner_ != nullptr;
}

std::vector<model::Learnt> LinePoller::learnt(Instant t) const {
    if (run_->learner_) return run_->learner_->learning().learnt(t);
    std::vector<model::Learnt> known;
    for (const auto& device : run_->line_.devices) known.push_back(device.learnt);
    return known;
}

bool LinePoller::copy_learnt(Instant t, std::span<model::Learnt> into) const {
    if (run_->learner_) return run_->learner_->learning().copy_learnt(t, into);
    for (std::size_t d = 0; d < run_->line_.devices.size(); ++d) {
        const auto& known = run_->line_.devices[d].learnt;
        for (std::size_t a = 0; a < known.refused.size(); ++a)
            if (into[d].confirmed[a].capacity() < known.confirmed[a].size() ||
                into[d].refused[a].capacity() < known.refused[a].size())
                return false;
        into[d] = known;
    }
    return true;
}

model::MeasuredTimes LinePoller::measured(std::size_t device) const {
    return run_->devices_[device].delay_learner.measured();
}

bool LinePoller::lengths_are_off() const {
    return run_->lengths_are_off();
}

std::vector<model::LearntTimes> LinePoller::learnt_times() const {
    std::vector<model::LearntTimes> times;
    times.reserve(run_->devices_.size());
    for (const auto& device : run_->devices_) times.push_back(device.delay_learner.learnt());
    return times;
}

std::uint64_t LinePoller::plan_revision() const {
    return run_->plan_revision_;
}
const plan::LinePlan& LinePoller::plan() const {
    return *run_->plan_;
}

}  // namespace takt::poll
