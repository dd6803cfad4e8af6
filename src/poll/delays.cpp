// Responses that come later than the project says: after the time-out, or after the turnaround.
#include <algorithm>
#include <bit>

#include "run.hpp"
#include "takt/bus/expired_requests.hpp"
#include "takt/wire/frame.hpp"

namespace takt::poll {
namespace {

constexpr int kSlowOnes = 3;  // of the last eight responses

}  // namespace

std::string_view name(DelayFinding::Setting setting) {
    return setting == DelayFinding::Setting::turnaround ? "turnaround" : "response_timeout";
}

void LinePoller::Run::on_late(const bus::LateResponse& late) {
    const auto found = std::ranges::find_if(
        devices_, [&](const DeviceRun& device) { return device.model->address == late.unit; });
    if (found == devices_.end()) return;
    auto& device = *found;
    ++device.statistics.late;
    if (late.delay <= late.wait) return;  // the transaction ended for another reason
    const bool by_turnaround = device.model->turnaround && !device.model->response_timeout_set &&
                               device.wait < device.model->response_timeout;
    note_delay(late.at, device, late.delay,
               by_turnaround ? DelayFinding::Setting::turnaround : DelayFinding::Setting::response_timeout);
}

// Behind a gateway a response waits for those to the requests in flight before it.
void LinePoller::Run::check_turnaround(DeviceRun& device, const bus::Outcome& outcome) {
    if (!device.model->turnaround || outcome.response.empty() || engine_.config().in_flight > 1) return;
    const auto& config = engine_.config();
    const auto characters = wire::frame_length(config.framing, outcome.response.pdu().size());
    const Duration length =
        config.is_serial() ? wire::transmission_time(config.format, characters) : Duration::zero();
    const Duration delay = outcome.ended_at - length - outcome.request_end;
    const bool slow = delay > std::max(*device.model->turnaround,
                                       line_.is_serial() ? engine_.silence() : Duration::zero()) +
                                  config.margin;
    device.slow_ones = static_cast<std::uint8_t>(device.slow_ones << 1 | (slow ? 1 : 0));
    if (slow && std::popcount(device.slow_ones) >= kSlowOnes)
        note_delay(outcome.ended_at, device, delay, DelayFinding::Setting::turnaround);
}

// The first finding about the time-out replaces one about the turnaround.
void LinePoller::Run::note_delay(Instant t, DeviceRun& device, Duration delay,
                                 DelayFinding::Setting setting) {
    auto& known = device.statistics.delays;
    if (known && known->setting == DelayFinding::Setting::response_timeout && setting != known->setting)
        return;
    const bool same = known && known->setting == setting;
    if (same && delay <= known->delay) return;
    const Duration advised = bus::advised_timeout(delay);
    const bool report = !same || advised > known->advised;
    known =
        DelayFinding{.setting = setting,
                     .delay = delay,
                     .limit = setting == DelayFinding::Setting::turnaround ? *device.model->turnaround
                                                                           : device.model->response_timeout,
                     .advised = advised};
    if (report && observer_)
        observer_->on_delays(t, plan_->line, static_cast<std::size_t>(&device - devices_.data()), *known);
}

}  // namespace takt::poll
