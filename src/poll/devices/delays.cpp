// Response times: what the line measures of each device, and what it reports (delay_learner.hpp).
#include "line/run.hpp"
#include "takt/plan/guarantee.hpp"

namespace takt::poll {

void LinePoller::Run::begin_measuring(DeviceRun& device) {
    const bool grows = device.model->learn_turnaround && project_.derive_timeouts &&
                       !device.model->response_timeout_set && engine_.config().in_flight <= 1;
    device.delay_learner =
        DelayLearner(*device.model, plan::answer_wait(project_, line_, *device.model), grows);
    device.times.lateness = device.delay_learner.lateness();
}

void LinePoller::Run::on_late(const bus::LateResponse& late) {
    const auto index = device_at(late.unit);
    if (!index) return;
    auto& device = devices_[*index];
    ++device.statistics.late;
    device.times.on_late(late);
    settle_held(late.at, *index);
    report_delay(late.at, *index, device.delay_learner.on_late(late.least_delay, late.wait));
    if (late.out_of_order_since) degrade_shifted(late.at, device, late.shape, *late.out_of_order_since);
}

// Behind a gateway a response waits for those to the requests in flight before it.
void LinePoller::Run::measure_delay(std::size_t index, const bus::Outcome& outcome, bool answered) {
    auto& device = devices_[index];
    const auto& config = engine_.config();
    const bool broadcast = config.framing != wire::Framing::tcp && outcome.unit == kBroadcast;
    if (!outcome.sent || broadcast || outcome.status == bus::Status::link_lost) return;
    device.delay_learner.on_attempt();
    const Duration delay = bus::response_delay(config, outcome);
    const bool responded = answered && !outcome.response.empty();
    if (config.in_flight > 1) {  // no property of the device alone: it is not learnt
        if (responded) exchange_times_.on_response(config, outcome, delay);
        return;
    }
    if (outcome.status == bus::Status::ambiguous) return device.times.on_response(delay, false);
    if (outcome.status == bus::Status::timeout) return device.times.on_missing();
    if (!responded) return;
    exchange_times_.on_response(config, outcome, delay);
    const Duration silence = line_.is_serial() ? engine_.silence() : Duration::zero();
    const Duration tolerated =
        std::max(device.model->turnaround.value_or(Duration::zero()), silence) + config.margin;
    device.times.on_response(delay, !engine_.remembers(outcome.unit));
    report_delay(outcome.ended_at, index, device.delay_learner.on_response(delay, tolerated));
}

void LinePoller::Run::report_delay(Instant t, std::size_t index, const std::optional<DelayFinding>& found) {
    const bool news = devices_[index].delay_learner.take_news();
    if (!observer_) return;
    if (found) observer_->on_delays(t, plan_->line, index, *found);
    if (news) observer_->on_measured(t, plan_->line, index);
}

}  // namespace takt::poll
