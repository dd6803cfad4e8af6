#include "outputs/delivery_pace.hpp"

#include <algorithm>

namespace takt::publish {

std::uint64_t DeliveryPace::note(Instant now, const OutputStatus& status) {
    const bool is_full = status.state == OutputState::delivering && status.mqtt && status.mqtt->window > 0 &&
                         status.mqtt->in_flight >= status.mqtt->window;
    if (!is_full) {
        *this = DeliveryPace();
        return 0;
    }
    const bool has_moved = delivered_ != status.samples.delivered;
    delivered_ = status.samples.delivered;
    const Count count{now, status.samples};
    if (!begin_) begin_ = count;
    if (now - begin_->at >= kInterval && has_moved) end_interval(count);
    return behind_per_s_;
}

// Dropped samples were made and not delivered: what waits does not grow any more when the quota is full.
void DeliveryPace::end_interval(const Count& end) {
    constexpr std::uint64_t kNoise = 20;  // one in so many samples
    const auto made = end.samples.sampled - begin_->samples.sampled;
    const auto delivered = end.samples.delivered - begin_->samples.delivered;
    const auto missing = made - std::min(made, delivered);
    const bool grows = missing * kNoise > made;
    const double seconds = std::chrono::duration<double>(end.at - begin_->at).count();
    const auto per_second = static_cast<std::uint64_t>(static_cast<double>(missing) / seconds);
    behind_per_s_ = grows && has_grown_ ? std::max<std::uint64_t>(per_second, 1) : 0;
    has_grown_ = grows;
    begin_ = end;
}

}  // namespace takt::publish
