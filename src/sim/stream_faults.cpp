#include "stream_faults.hpp"

#include <algorithm>

#include "damage.hpp"

namespace takt::sim {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kClient = 0;
constexpr std::size_t kServer = 1;
constexpr Duration kLatestDuplicate = 2s;

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
    const Exchange exchange = std::move(answers_.front());
    answers_.pop_front();
    if (exchange.dropped) return true;
    if (!exchange.device) return false;
    if (framing_ != wire::Framing::tcp && t > exchange.latest) {
        ++counts_.withheld;
        return true;
    }
    if (t > exchange.deadline) {
        count(t, FaultKind::late_response, exchange.device);
        return lost_for_what_was_before(frame);
    }
    if (!exchange.kind) return lost_for_what_was_before(frame);
    return spoil(t, exchange, frame, arrives);
}

bool StreamFaults::spoil(Instant t, const Exchange& exchange, Bytes frame, std::vector<Piece>& arrives) {
    switch (*exchange.kind) {
        case FaultKind::late_response:
            // The rest of an earlier response has ended the transaction already: one fault at a time.
            if (framing_ != wire::Framing::tcp && !tail_.empty()) {
                ++counts_.withheld;
                return true;
            }
            hold_back(t, exchange, frame, arrives);
            break;
        case FaultKind::duplicate_response: double_up(frame, arrives); break;
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

void StreamFaults::hold_back(Instant t, const Exchange& exchange, Bytes frame, std::vector<Piece>& arrives) {
    const Instant latest = std::max(exchange.latest, exchange.deadline);
    arrives.push_back({.delay = random_.between(exchange.deadline - t, latest - t),
                       .sent_later = true,
                       .bytes = {frame.begin(), frame.end()}});
}

void StreamFaults::double_up(Bytes frame, std::vector<Piece>& arrives) {
    arrives.push_back({.bytes = {frame.begin(), frame.end()}});
    Piece again = arrives.back();
    again.delay = random_.between(0ms, kLatestDuplicate);
    again.sent_later = true;
    if (framing_ == wire::Framing::tcp)
        arrives.push_back(std::move(again));
    else  // a later one cannot be distinguished from the next response
        arrives.back().bytes.insert(arrives.back().bytes.end(), frame.begin(), frame.end());
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
    if (stream_->stalled()) stream_->stall(t, false);
    if (swallows_) close(t);
    if (!stream_->up()) schedule_begin(t, FaultKind::connect_refused, {});
}

}  // namespace takt::sim
