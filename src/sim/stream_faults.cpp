#include "stream_faults.hpp"

#include <algorithm>

#include "damage.hpp"

namespace takt::sim {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kClient = 0;
constexpr std::size_t kServer = 1;

}  // namespace

// ---- the way of the bytes

bool StreamFaults::on_sent(Instant t, std::size_t sender, Bytes sent, std::vector<Piece>& arrives) {
    counts_.bytes += sent.size();
    if (sender == kClient) {
        ++counts_.exchanges;
        tail_.clear();
        return false;
    }
    bool otherwise = false;
    for (std::size_t length = 0; !sent.empty() && !swallows_; sent = sent.subspan(length)) {
        length = first_response_length(framing_, sent);
        if (on_frame(t, sent.first(length), arrives))
            otherwise = true;
        else
            arrives.push_back({.bytes = {sent.begin(), sent.begin() + static_cast<std::ptrdiff_t>(length)}});
    }
    return otherwise;
}

bool StreamFaults::on_frame(Instant t, Bytes frame, std::vector<Piece>& arrives) {
    if (answers_.empty()) return false;
    const Exchange exchange = answers_.front();
    answers_.pop_front();
    if (exchange.dropped) return true;
    if (!exchange.device) return false;
    if (queue_up(t, exchange, frame, arrives)) return true;
    note_sent(*exchange.device, frame);
    if (t > exchange.deadline) count(t, FaultKind::late_response, exchange.device);
    if (!exchange.kind) return lost_for_what_was_before(frame);
    return spoil(t, exchange, frame, arrives);
}

bool StreamFaults::spoil(Instant t, const Exchange& exchange, Bytes frame, std::vector<Piece>& arrives) {
    switch (*exchange.kind) {
        case FaultKind::duplicate_response: double_up(t, *exchange.device, frame, arrives); break;
        case FaultKind::past_response:
            if (!send_past(t, *exchange.device, frame, arrives)) return lost_for_what_was_before(frame);
            break;
        case FaultKind::glitch: add_glitch(t, frame, arrives); break;
        case FaultKind::fragmented:
            if (!break_up(t, exchange, frame, arrives)) return false;
            break;
        default: {
            Piece piece;
            if (!spoil_answer(*exchange.kind, exchange, frame, piece.bytes))
                return lost_for_what_was_before(frame);
            if (!piece.bytes.empty()) arrives.push_back(std::move(piece));
            // The header promises bytes that never come. Any other bytes would be taken for them.
            if (*exchange.kind == FaultKind::truncated && framing_ == wire::Framing::tcp)
                swallow(t, t + duration(plan_.half_open));
        }
    }
    count(t, *exchange.kind, exchange.device);
    return true;
}

bool StreamFaults::queue_up(Instant t, const Exchange& exchange, Bytes frame, std::vector<Piece>& arrives) {
    const std::size_t device = *exchange.device;
    Instant ready = t;
    const bool late = exchange.kind == FaultKind::late_response;
    if (late) ready = t + lateness(device);
    if (in_order(device)) {
        Instant& behind = behind_until_[device];
        if (behind > t) ready = std::max(ready, behind + 1ms);
        if (ready > t) behind = ready;
    }
    if (ready == t) return false;
    note_sent(device, frame);
    if (ready > exchange.deadline) count(t, FaultKind::late_response, device, ready);
    send_later(t, ready - t, frame, arrives);
    return true;
}

// What would come after the faults is lost.
void StreamFaults::send_later(Instant t, Duration delay, Bytes bytes, std::vector<Piece>& arrives) const {
    if (t + delay >= plan_.quiet_from) return;
    arrives.push_back({.delay = delay, .sent_later = true, .bytes = {bytes.begin(), bytes.end()}});
}

void StreamFaults::double_up(Instant t, std::size_t device, Bytes frame, std::vector<Piece>& arrives) {
    arrives.push_back({.bytes = {frame.begin(), frame.end()}});
    const ByteString copy = copy_of(random_, framing_, frame);
    if (random_.below(3) == 0) {
        arrives.back().bytes.insert(arrives.back().bytes.end(), copy.begin(), copy.end());
    } else if (serves_again(device)) {
        behind_until_[device] = t + service_time();
        send_later(t, behind_until_[device] - t, copy, arrives);
    } else {
        send_later(t, copy_delay(), copy, arrives);
    }
}

bool StreamFaults::send_past(Instant t, std::size_t device, Bytes frame, std::vector<Piece>& arrives) {
    ByteString past = past_answer(device, frame);
    if (past.empty()) return false;
    arrives.push_back({.bytes = std::move(past)});
    if (random_.below(4) != 0) send_later(t, random_.between(0ms, 300ms), frame, arrives);
    return true;
}

void StreamFaults::add_glitch(Instant t, Bytes frame, std::vector<Piece>& arrives) {
    const bool before = random_.below(3) != 0;
    const ByteString glitch = glitch_for(frame, before);
    const Bytes first = before ? Bytes(glitch) : frame;
    const Bytes second = before ? frame : Bytes(glitch);
    arrives.push_back({.bytes = {first.begin(), first.end()}});
    if (random_.below(2) == 0)
        arrives.back().bytes.insert(arrives.back().bytes.end(), second.begin(), second.end());
    else
        send_later(t, random_.between(0ms, 8ms), second, arrives);
}

bool StreamFaults::break_up(Instant t, const Exchange& exchange, Bytes frame, std::vector<Piece>& arrives) {
    if (frame.size() < 2) return false;
    const Duration most = random_.below(2) == 0 ? Duration(20ms) : (exchange.deadline - t) * 3 / 2;
    Duration delay{};
    std::size_t begin = 0;
    while (begin < frame.size()) {
        const std::size_t left = frame.size() - begin;
        const std::size_t size = 1 + random_.below(static_cast<std::uint32_t>(begin == 0 ? left - 1 : left));
        const Bytes part = frame.subspan(begin, size);
        if (begin + size < frame.size() && could_mislead(frame.first(begin + size), false, frame)) {
            ++counts_.redrawn;
            arrives.clear();
            return true;
        }
        arrives.push_back({.delay = delay, .bytes = {part.begin(), part.end()}});
        delay = std::min(delay + random_.between(1us, std::max<Duration>(most, 1us)),
                         std::max<Duration>(2 * most, 1ms));
        begin += size;
    }
    return true;
}

void StreamFaults::on_arrived(Instant, std::size_t sender, Bytes sent, Bytes received) {
    if (sender != kServer) return;
    backoff_.reset();
    const bool good = std::ranges::equal(sent, received);
    remember(received, good);
    for (std::size_t length = 0; good && !received.empty(); received = received.subspan(length)) {
        length = first_response_length(framing_, received);
        note_answer(received.first(length));
    }
}

// ---- devices

std::optional<FaultKind> StreamFaults::drawn_for(std::size_t device, Bytes) {
    return draw(device);
}

void StreamFaults::device_died(std::size_t device) {
    for (Exchange& exchange : answers_) exchange.dropped = exchange.dropped || exchange.device == device;
}

// ---- the connection

void StreamFaults::swallow(Instant t, Instant until) {
    swallows_ = true;
    swallows_until_ = std::max(until, t);
    stream_->swallow();
    schedule_end(swallows_until_, FaultKind::tcp_half_open, {});
}

void StreamFaults::close(Instant t) {
    if (!stream_->up()) return;
    stream_->set_link(t, false);
    on_closed(t);
}

void StreamFaults::begin_anew() {
    answers_.clear();
    behind_until_.clear();
    tail_.clear();
    swallows_ = false;
}

void StreamFaults::on_closed(Instant t) {
    begin_anew();
    schedule_begin(t + backoff_.next(), FaultKind::connect_refused, {});
}

void StreamFaults::connect(Instant t) {
    if (stream_->up() || !running_) return;
    const auto refused = plan_.rates.per_million[static_cast<std::size_t>(FaultKind::connect_refused)];
    if (!quiet_ && random_.chance(refused)) {
        count(t, FaultKind::connect_refused, {});
        schedule_begin(t + backoff_.next(), FaultKind::connect_refused, {});
        return;
    }
    stream_->set_link(t, true);
}

void StreamFaults::begin(Instant t, FaultKind kind, std::optional<std::size_t> device) {
    if (stream_->stalled()) return schedule_begin(t + 100ms, kind, device);
    if (kind == FaultKind::connect_refused) return connect(t);
    if (stream_->up()) {
        Instant until = t;
        if (kind == FaultKind::clock_jump)
            stream_->stall(until = t + duration(plan_.jump), random_.below(2) == 0);
        if (kind == FaultKind::tcp_half_open) swallow(t, until = t + duration(plan_.half_open));
        if (kind == FaultKind::tcp_reset) close(t);
        count(t, kind, {}, until);
    }
    schedule(t, kind, device);
}

void StreamFaults::end(Instant t, FaultKind kind) {
    if (kind == FaultKind::tcp_half_open && swallows_ && t >= swallows_until_) close(t);
}

void StreamFaults::end_all(Instant t) {
    behind_until_.clear();
    if (stream_->stalled()) stream_->stall(t, false);
    if (swallows_) close(t);
    if (!stream_->up()) schedule_begin(t, FaultKind::connect_refused, {});
}

}  // namespace takt::sim
