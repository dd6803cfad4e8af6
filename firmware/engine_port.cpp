#include "takt/firmware/engine_port.hpp"

#include <algorithm>

namespace takt::firmware {
namespace {

// The clock of the board is read at least so often, long before it wraps around.
constexpr Duration kLongestSleep = std::chrono::minutes(10);

}  // namespace

bool EnginePort::start(const wire::CharacterFormat& format) {
    if (!board::open(format, *this, port_)) return false;
    if (!open_) clock_ = board::clock();
    open_ = true;
    taken_ = received_.load();
    engine_.on_link(now(), true);
    timer_passed_ = true;
    return true;
}

Instant EnginePort::now() {
    const std::uint32_t clock = board::clock();
    now_ += std::chrono::microseconds(clock - clock_);
    clock_ = clock;
    return now_;
}

bool EnginePort::work() {
    if (!has_work()) return false;
    timer_passed_ = sent_all_ = false;
    take_received();
    called_ = now();
    if (called_ >= engine_.next_wakeup()) engine_.on_tick(called_);
    if (!sending_) send_next();
    const Instant next = std::min(engine_.next_wakeup(), now() + kLongestSleep);
    const auto left = std::chrono::ceil<std::chrono::microseconds>(next - now_).count();
    board::start_timer(left > 0 ? static_cast<std::uint32_t>(left) : 1, port_);
    return true;
}

// The last character ended at received_at_; the ring has what came up to then, or one more.
void EnginePort::take_received() {
    InplaceVector<std::uint8_t, kMostWaiting> bytes;
    const std::uint32_t end = received_;
    const std::uint32_t at = received_at_;
    for (std::uint32_t i = taken_; i != end; ++i) bytes.push_back(ring_[i % kMostWaiting]);
    taken_ = end;
    if (bytes.empty()) return;
    static_cast<void>(now());
    const auto ago = std::chrono::microseconds(clock_ - at);
    // Those that came while the engine was called with a later time count from then.
    called_ = std::max(called_, now_ - ago);
    engine_.on_bytes(called_, bytes.span());
}

void EnginePort::send_next() {
    const Bytes bytes = engine_.transmit(called_);
    if (bytes.empty()) return;
    out_.assign(bytes);
    sent_ = 0;
    sending_ = true;
    board::drive_line(true, port_);
    board::send(out_[0], port_);
}

void EnginePort::on_character(std::uint8_t character, bool /*damaged*/) {
    received_at_ = board::clock();
    if (received_ - taken_ == kMostWaiting) return;
    ring_[received_ % kMostWaiting] = character;
    received_ = received_ + 1;
}

void EnginePort::on_sent() {
    if (!sending_) return;
    if (++sent_ < out_.size()) return board::send(out_[sent_], port_);
    board::drive_line(false, port_);
    sending_ = false;
    sent_all_ = true;
}

}  // namespace takt::firmware
