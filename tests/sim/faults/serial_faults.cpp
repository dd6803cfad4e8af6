#include "serial_faults.hpp"

#include <algorithm>
#include <utility>

#include "damage.hpp"

namespace takt::sim {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kMaster = 0;
constexpr std::size_t kDevices = 1;

bool spoils_characters(FaultKind kind) {
    return kind <= FaultKind::repeated_byte;
}

}  // namespace

SerialFaults::SerialFaults(const model::Line& line, Devices& devices, const FaultPlan& plan,
                           FaultObserver* observer)
    : FaultInjector(line, devices, plan, observer), stations_(line.devices.size()) {}

// ---- the way of the bytes

bool SerialFaults::on_sent(Instant t, std::size_t sender, Bytes sent, std::vector<Piece>& arrives) {
    counts_.bytes += sent.size();
    if (sender == kMaster) return on_request(t, sent, arrives);
    if (sending_later_) return false;
    return sender == kDevices && on_answer(t, sent, arrives);
}

std::optional<std::size_t> SerialFaults::addressee(Bytes frame, bool& broadcast) const {
    std::uint8_t unit = frame[0];
    if (framing_ == wire::Framing::ascii) {
        const auto open = open_frame(framing_, frame);
        unit = open ? open->unit : std::uint8_t{0};
    }
    broadcast = unit == kBroadcast.value;
    return device_of(unit);
}

bool SerialFaults::on_request(Instant t, Bytes sent, std::vector<Piece>& arrives) {
    bool broadcast = false;
    const auto device = addressee(sent, broadcast);
    if (device || broadcast) {
        ++counts_.exchanges;
        const auto kind = draw(device);
        const bool here = kind && (spoils_characters(*kind) ? broadcast || random_.below(2) == 0
                                                            : kind == FaultKind::lost_request);
        if (device) stations_[*device].drawn = here ? std::nullopt : kind;
        if (here) return spoil_request(t, *kind, device, sent, arrives);
    }
    const bool lost = lost_for_what_was_before(sent);
    tail_.clear();
    return lost;
}

bool SerialFaults::spoil_request(Instant t, FaultKind kind, std::optional<std::size_t> device, Bytes sent,
                                 std::vector<Piece>& arrives) {
    if (kind != FaultKind::lost_request)
        arrives.push_back({.bytes = harmless([&] { return spoil_characters(random_, kind, sent); }, sent)});
    count(t, kind, device);
    return true;
}

bool SerialFaults::on_answer(Instant t, Bytes sent, std::vector<Piece>& arrives) {
    bool broadcast = false;
    const auto device = addressee(sent, broadcast);
    if (!device || !stations_[*device].exchange) return lost_for_what_was_before(sent);
    const Exchange exchange = *stations_[*device].exchange;
    stations_[*device].exchange.reset();
    if (exchange.dropped) return true;
    if (t + length(sent) > exchange.deadline) count(t, FaultKind::late_response, device);
    note_sent(*device, sent);
    if (!exchange.kind) return lost_for_what_was_before(sent);
    ByteString instead;
    bool changed = false;
    switch (*exchange.kind) {
        case FaultKind::duplicate_response: changed = copy(t, *device, sent, instead); break;
        case FaultKind::past_response: changed = send_past(t, *device, sent, instead); break;
        case FaultKind::glitch: changed = add_glitch(t, *device, sent, instead); break;
        default: changed = spoil_answer(*exchange.kind, exchange, sent, instead);
    }
    if (!changed) return lost_for_what_was_before(sent);
    count(t, *exchange.kind, device);
    arrives.push_back({.bytes = std::move(instead)});
    return true;
}

// A third of the copies follow directly. The others are counted when they are sent. A device that serves the
// request once more serves others after that.
bool SerialFaults::copy(Instant t, std::size_t device, Bytes sent, ByteString& instead) {
    if (random_.below(3) != 0) {
        const bool again = serves_again(device);
        const Duration delay = again ? service_time() : copy_delay();
        send_later(t + length(sent) + delay, device, FaultKind::duplicate_response, sent);
        later_.back().again = again;
        return false;
    }
    instead.assign(sent.begin(), sent.end());
    instead.insert(instead.end(), sent.begin(), sent.end());
    return true;
}

bool SerialFaults::send_past(Instant t, std::size_t device, Bytes sent, ByteString& instead) {
    instead = past_answer(device, sent);
    if (instead.empty()) return false;
    if (random_.below(4) != 0)
        send_later(t + length(instead) + random_.between(2ms, 300ms), device, std::nullopt, sent);
    return true;
}

bool SerialFaults::add_glitch(Instant t, std::size_t device, Bytes sent, ByteString& instead) {
    const bool before = random_.below(3) != 0;
    const bool apart = random_.below(2) == 0;
    const ByteString glitch = glitch_for(sent, before);
    instead = before ? glitch : ByteString(sent.begin(), sent.end());
    const Bytes second = before ? sent : Bytes(glitch);
    if (apart)
        send_later(t + length(instead) + random_.between(0ms, 8ms), device, std::nullopt, second);
    else
        instead.insert(instead.end(), second.begin(), second.end());
    return true;
}

// ---- answers at other times

bool SerialFaults::postpone(Instant t, const Exchange& exchange, UnitId unit, const serve::Answer& answer) {
    const std::size_t device = *exchange.device;
    const bool late = exchange.kind == FaultKind::late_response;
    Instant ready = t + answer.delay;
    if (late) ready = t + lateness(device);
    if (in_order(device))
        for (const Later& earlier : later_)
            if (earlier.device == device && (earlier.again || earlier.kind == FaultKind::late_response))
                ready = std::max(ready, earlier.when + answer.delay + 1ms);
    if (!late && ready == t + answer.delay) return false;
    const auto pdu = answer.pdu.span();
    const ByteString frame = close_frame(framing_, {unit.value, 0, {pdu.begin(), pdu.end()}});
    send_later(ready, device, FaultKind::late_response, frame);
    later_.back().waits_for_silence = random_.below(4) != 0;
    return true;
}

void SerialFaults::send_later(Instant when, std::size_t device, std::optional<FaultKind> kind, Bytes bytes) {
    later_.push_back({.when = when,
                      .device = device,
                      .kind = kind,
                      .waits_for_silence = kind.has_value() && random_.below(4) != 0,
                      .bytes = {bytes.begin(), bytes.end()}});
    schedule_begin(when, FaultKind::late_response, device);
}

// In order: its first. Out of order: its earliest.
void SerialFaults::send_due(Instant t, std::size_t device) {
    auto due = later_.end();
    for (auto i = later_.begin(); i != later_.end(); ++i) {
        if (i->device != device || i->when > t) continue;
        if (due == later_.end() || (!in_order(device) && i->when < due->when)) due = i;
    }
    if (due == later_.end()) return;
    if (due->waits_for_silence && bus_->busy()) {
        due->when = t + random_.between(1ms, 20ms);
        return schedule_begin(due->when, FaultKind::late_response, device);
    }
    const Later later = std::move(*due);
    later_.erase(due);
    sending_later_ = true;
    bus_->send_from(t, kDevices, later.bytes);
    sending_later_ = false;
    if (!later.kind) return;
    note_sent(device, later.bytes);
    count(t, *later.kind, device);
}

void SerialFaults::on_arrived(Instant t, std::size_t sender, Bytes sent, Bytes received) {
    const bool good = std::ranges::equal(sent, received);
    remember(received, good);
    if (sender == kDevices && good) note_answer(received);
    if (sender == bus_->intruder() && t < babbles_until_) babble(t);
}

bool SerialFaults::misleads(Bytes received, std::size_t old, Bytes sent) {
    ByteString all = tail_;
    all.insert(all.end(), received.begin(), received.end());
    if (!sim::misleads(framing_, all, tail_.size() + old, false, sent, units_)) return false;
    ++counts_.redrawn;
    return true;
}

// ---- devices

std::optional<FaultKind> SerialFaults::drawn_for(std::size_t device, Bytes) {
    return std::exchange(stations_[device].drawn, std::nullopt);
}

void SerialFaults::answering(const Exchange& exchange) {
    if (exchange.device) stations_[*exchange.device].exchange = exchange;
}

void SerialFaults::device_died(std::size_t device) {
    if (auto& exchange = stations_[device].exchange) exchange->dropped = true;
    std::erase_if(later_, [device](const Later& later) { return later.device == device; });
}

// ---- by the clock

void SerialFaults::begin(Instant t, FaultKind kind, std::optional<std::size_t> device) {
    const bool standing_still = bus_->stalled(kMaster);
    if (standing_still && kind == FaultKind::link_down) return schedule_begin(t + 100ms, kind, device);
    switch (kind) {
        case FaultKind::late_response: return send_due(t, *device);
        case FaultKind::noise:
            if (bus_->busy()) return schedule_begin(t + random_.between(1ms, 20ms), kind, device);
            bus_->inject(t, harmless([&] { return any_bytes(random_, 1 + random_.below(8)); }, {}));
            count(t, kind, {});
            break;
        case FaultKind::device_babbles:
            if (silent(*device)) break;
            babbles_until_ = std::max(babbles_until_, t + duration(plan_.babble));
            count(t, kind, device, babbles_until_);
            if (!bus_->intrudes()) babble(t);
            break;
        case FaultKind::clock_jump: {
            if (standing_still) break;
            const Instant until = t + duration(plan_.jump);
            bus_->stall(kMaster, until, random_.below(2) == 0);
            count(t, kind, {}, until);
            break;
        }
        case FaultKind::link_down: {
            const Instant until = t + duration(plan_.unplugged);
            if (!running_) break;
            bus_->plug(t, kMaster, false);
            count(t, kind, {}, until);
            return schedule_end(until, kind, {});
        }
        default: return;
    }
    schedule(t, kind, device);
}

void SerialFaults::end(Instant t, FaultKind kind) {
    if (kind != FaultKind::link_down) return;
    bus_->plug(t, kMaster, running_);
    count(t, FaultKind::link_up, {});
    if (!quiet_) schedule(t, kind, {});
}

void SerialFaults::end_all(Instant t) {
    babbles_until_ = t;
    later_.clear();
    if (bus_->stalled(kMaster)) bus_->stall(kMaster, t, false);
}

void SerialFaults::babble(Instant t) {
    bus_->inject(t, harmless([&] { return any_bytes(random_, 64 + random_.below(192)); }, {}));
}

}  // namespace takt::sim
