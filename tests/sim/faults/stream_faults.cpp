#include "stream_faults.hpp"

#include <algorithm>
#include <utility>

#include "damage.hpp"

namespace takt::sim {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kClient = 0;
constexpr std::size_t kServer = 1;
constexpr Duration kLongestBackoff = 5s;

}  // namespace

// ---- the way of the bytes

bool StreamFaults::on_sent(Instant t, std::size_t sender, Bytes sent, std::vector<Piece>& arrives) {
    counts_.bytes += sent.size();
    active_at_ = t;
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
    const auto closes = per_million(FaultKind::close_after_response);
    if (closes > 0 && random_.chance(closes)) {
        const bool at_once = random_.below(2) == 0;
        end_connection_at(at_once ? t : t + random_.between(0ms, 3ms), FaultKind::close_after_response,
                          exchange.device);
    }
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

void StreamFaults::begin_anew() {
    answers_.clear();
    behind_until_.clear();
    tail_.clear();
    swallows_ = false;
    end_.reset();
}

void StreamFaults::on_closed(Instant t) {
    begin_anew();
    if (t - connected_at_ >= kLongestBackoff) backoff_.reset();
    if (!stream_->client_opens_at()) back_off(t);
}

void StreamFaults::back_off(Instant t) {
    backs_off_ = true;
    schedule_begin(t + backoff_.next(), FaultKind::connect_refused, {});
}

Instant StreamFaults::connects_at() const {
    if (stream_->up() || stream_->stalled() || backs_off_ || !running_) return kNever;
    return stream_->client_opens_at().value_or(Instant::min());
}

void StreamFaults::connect(Instant t) {
    backs_off_ = false;
    if (stream_->up() || !running_) return;
    if (const auto refused = per_million(FaultKind::connect_refused);
        refused > 0 && random_.chance(refused)) {
        count(t, FaultKind::connect_refused, {});
        stream_->set_link(t, false);
        return back_off(t);
    }
    connected_at_ = active_at_ = t;
    stream_->set_link(t, true);
}

// ---- a server that ends its connections

// A server that closes for some requests does so for those to a dead device, too.
std::optional<FaultKind> StreamFaults::closes_for(const serve::Context& context, Bytes request) {
    if (const auto rate = per_million(FaultKind::close_on_request); rate > 0) {
        constexpr std::size_t kRange = 5;  // function, address, quantity
        std::uint64_t name = context.unit.value;
        for (const auto byte : request.first(std::min(kRange, request.size()))) name = name << 8 | byte;
        const auto device = device_of(context.unit.value);
        if ((device && silent(*device)) || Random(plan_.seed ^ name).fork(name).chance(rate))
            return FaultKind::close_on_request;
    }
    const auto rate = per_million(FaultKind::close_at_random);
    return rate > 0 && random_.chance(rate) ? std::optional(FaultKind::close_at_random) : std::nullopt;
}

serve::Answer StreamFaults::handle(const serve::Context& context, const wire::RequestView& request) {
    const auto kind = context.broadcast ? std::nullopt : closes_for(context, request.pdu());
    if (!kind) return FaultInjector::handle(context, request);
    const auto device = device_of(context.unit.value);
    if (random_.below(2) == 0) (void)devices_.handle(context, request);
    const bool draws = device && *device < plan_.turnarounds.size() && plan_.turnarounds[*device];
    end_connection_at(context.time + (draws ? plan_.turnarounds[*device]->draw(random_) : 1ms), *kind,
                      device);
    return {};
}

void StreamFaults::end_connection_at(Instant when, FaultKind kind, std::optional<std::size_t> device) {
    if (!end_ || when < end_->when) end_ = {when, kind, device};
}

Instant StreamFaults::idle_until() const {
    const Duration idle = plan_.rates.mean_between[static_cast<std::size_t>(FaultKind::close_when_idle)];
    return idle > Duration::zero() && !quiet_ && stream_->open() ? active_at_ + idle : kNever;
}

void StreamFaults::end_connection(Instant t) {
    const auto end = std::exchange(end_, std::nullopt);
    if (!stream_->open()) return;
    count(t, end->kind, end->device);
    stream_->end(t, static_cast<Ending>(random_.below(3)));
}

Instant StreamFaults::next_event() const {
    const Instant ends_at = end_ ? end_->when : kNever;
    return std::min({FaultInjector::next_event(), connects_at(), ends_at, idle_until()});
}

void StreamFaults::on_event(Instant t) {
    FaultInjector::on_event(t);
    if (idle_until() <= t) end_connection_at(t, FaultKind::close_when_idle, {});
    if (end_ && end_->when <= t) end_connection(t);
    if (connects_at() <= t) connect(t);
}

void StreamFaults::begin(Instant t, FaultKind kind, std::optional<std::size_t> device) {
    if (stream_->stalled()) return schedule_begin(t + 100ms, kind, device);
    if (kind == FaultKind::connect_refused) return connect(t);
    if (is_close(kind)) return;  // see on_event()
    if (stream_->up()) {
        Instant until = t;
        if (kind == FaultKind::clock_jump)
            stream_->stall(until = t + duration(plan_.jump), random_.below(2) == 0);
        if (kind == FaultKind::tcp_half_open) swallow(t, until = t + duration(plan_.half_open));
        if (kind == FaultKind::tcp_reset) stream_->end(t, Ending::reset);
        count(t, kind, {}, until);
    }
    schedule(t, kind, device);
}

void StreamFaults::end(Instant t, FaultKind kind) {
    if (kind == FaultKind::tcp_half_open && swallows_ && t >= swallows_until_) stream_->close(t);
}

void StreamFaults::end_all(Instant t) {
    behind_until_.clear();
    end_.reset();
    if (stream_->stalled()) stream_->stall(t, false);
    if (swallows_) stream_->close(t);
    if (backs_off_) schedule_begin(t, FaultKind::connect_refused, {});
}

}  // namespace takt::sim
