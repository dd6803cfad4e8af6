#include "serial_faults.hpp"

#include <algorithm>

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
    if (t > exchange.latest) {
        ++counts_.withheld;
        return true;
    }
    const bool late = t + wire::transmission_time(format_, sent.size()) > exchange.deadline;
    if (late) count(t, FaultKind::late_response, device);
    if (!exchange.kind || late) return lost_for_what_was_before(sent);
    std::vector<std::uint8_t> instead;
    if (*exchange.kind == FaultKind::duplicate_response) {
        // A frame delivered at its end must not look like silence up to the master's time-out.
        if (t + wire::transmission_time(format_, 2 * sent.size()) > exchange.deadline)
            return lost_for_what_was_before(sent);
        if (lost_for_what_was_before(sent)) return true;
        instead.assign(sent.begin(), sent.end());
        instead.insert(instead.end(), sent.begin(), sent.end());
    } else if (!spoil_answer(*exchange.kind, exchange, sent, instead)) {
        return lost_for_what_was_before(sent);
    }
    count(t, *exchange.kind, device);
    arrives.push_back({.bytes = std::move(instead)});
    return true;
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
}

bool SerialFaults::late_answer_waits(std::uint8_t unit) const {
    const auto device = device_of(unit);
    return device && stations_[*device].exchange;
}

// ---- by the clock

void SerialFaults::begin(Instant t, FaultKind kind, std::optional<std::size_t> device) {
    const bool standing_still = bus_->stalled(kMaster);
    if (standing_still && kind == FaultKind::link_down) return schedule_begin(t + 100ms, kind, device);
    switch (kind) {
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
    if (bus_->stalled(kMaster)) bus_->stall(kMaster, t, false);
}

void SerialFaults::babble(Instant t) {
    bus_->inject(t, harmless([&] { return any_bytes(random_, 64 + random_.below(192)); }, {}));
}

}  // namespace takt::sim
