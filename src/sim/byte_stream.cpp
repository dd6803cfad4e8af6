// Virtual time as in serial_bus.cpp. Order within one instant: faults, deferred bytes, bytes to the server,
// end of a suspension, bytes to the client, on_tick() of server and client, transmit() of server and client,
// close. Bytes to the server wait while it wants none, as in the receive window of TCP.
#include "byte_stream.hpp"

#include <algorithm>
#include <utility>

#include "stepping.hpp"

namespace takt::sim {

ByteStream::ByteStream(Engine& client, serve::TcpConnection& server, const Options& options)
    : client_(client), server_(server), options_(options) {}

void ByteStream::stall(Instant until, bool late_tick) {
    stalled_until_ = until;
    late_tick_ = late_tick;
}

void ByteStream::set_link(Instant t, bool up) {
    begin_anew(t, up);
    client_.on_link(now_, up);
    collect_all(now_);
}

void ByteStream::close(Instant t) {
    begin_anew(t, false);
    client_.on_close(now_);
    if (disturber_) disturber_->on_closed(now_);
    collect_all(now_);
}

void ByteStream::begin_anew(Instant t, bool up) {
    now_ = std::max(now_, t);
    up_ = up;
    swallows_ = false;
    ended_.reset();
    to_server_.clear();
    to_client_.clear();
    deferred_.clear();
    server_.on_link(now_, up);
}

void ByteStream::end(Instant t, Ending how) {
    if (!open()) return;
    if (how == Ending::reset) {
        to_client_.clear();
        deferred_.clear();
    }
    push(1, t, {}, {}, {});
    to_client_.back().ends = true;
    ended_ = how;
    if (how == Ending::half_close) return;
    to_server_.clear();
    server_.on_link(t, false);
}

void ByteStream::run_until(Instant t) {
    step_until(t, now_, [this] { return next_wakeup(); }, [this] { step(now_); });
    collect_all(now_);
    close_if_wanted(now_);
}

Instant ByteStream::next_wakeup() const {
    Instant next = std::min(stalled_until_.value_or(client_.next_wakeup()), server_.next_wakeup());
    if (disturber_) next = std::min(next, disturber_->next_event());
    for (const Deferred& later : deferred_) next = std::min(next, later.when);
    if (!to_client_.empty() && !stalled_until_) next = std::min(next, to_client_.front().arrives);
    if (!to_server_.empty() && server_.wants_bytes() > 0) next = std::min(next, to_server_.front().arrives);
    return next;
}

void ByteStream::step(Instant t) {
    if (disturber_ && disturber_->next_event() <= t) disturber_->on_event(t);
    send_deferred(t);
    to_server(t);
    if (stalled_until_ && *stalled_until_ <= t) wake_client(t);
    to_client(t);
    if (server_.next_wakeup() <= t) server_.on_tick(t);
    if (!stalled_until_ && client_.next_wakeup() <= t) client_.on_tick(t);
    collect_all(t);
    close_if_wanted(t);
}

void ByteStream::wake_client(Instant t) {
    stalled_until_.reset();
    if (late_tick_) client_.on_tick(t);
}

void ByteStream::close_if_wanted(Instant t) {
    const bool asked = options_.must_reconnect && !stalled_until_ && options_.must_reconnect();
    if (up_ && (asked || server_.close_reason() != serve::CloseReason::none)) close(t);
}

void ByteStream::to_server(Instant t) {
    while (!to_server_.empty() && to_server_.front().arrives <= t && server_.wants_bytes() > 0) {
        Chunk& chunk = to_server_.front();
        const std::size_t count = std::min(chunk.bytes.size() - chunk.taken, server_.wants_bytes());
        server_.on_bytes(t, Bytes(chunk.bytes).subspan(chunk.taken, count));
        chunk.taken += count;
        if (chunk.taken == chunk.bytes.size()) arrived(t, 0, to_server_);
    }
}

void ByteStream::to_client(Instant t) {
    while (!stalled_until_ && !to_client_.empty() && to_client_.front().arrives <= t) {
        if (to_client_.front().ends) return close(t);
        client_.on_bytes(t, to_client_.front().bytes);
        arrived(t, 1, to_client_);
    }
}

void ByteStream::arrived(Instant t, std::size_t sender, Queue& queue) {
    const Chunk& chunk = queue.front();
    const Bytes sent = chunk.sent ? Bytes(*chunk.sent) : Bytes(chunk.bytes);
    if (observer_) observer_->on_transmission({sender, chunk.start, chunk.arrives, sent, false, chunk.bytes});
    if (disturber_) disturber_->on_arrived(t, sender, sent, chunk.bytes);
    queue.pop_front();
}

void ByteStream::lost(Instant t, std::size_t sender, Bytes bytes) {
    if (observer_) observer_->on_transmission({sender, t, t, bytes, false, {}});
}

void ByteStream::collect_all(Instant t) {
    collect(server_, 1, t);
    if (!stalled_until_) collect(client_, 0, t);
}

void ByteStream::collect(Engine& engine, std::size_t sender, Instant t) {
    for (Bytes bytes = engine.transmit(t); !bytes.empty(); bytes = engine.transmit(t))
        if (up_) send(sender, t, bytes);
}

void ByteStream::send(std::size_t sender, Instant t, Bytes bytes) {
    if (swallows_ || (ended_ && (sender == 1 || ended_ != Ending::half_close))) return lost(t, sender, bytes);
    pieces_.clear();
    if (disturber_ && disturber_->on_sent(t, sender, bytes, pieces_)) return send_pieces(sender, t, bytes);
    push(sender, t, {}, {bytes.begin(), bytes.end()}, {});
}

// Sent bytes are reported with their first piece.
void ByteStream::send_pieces(std::size_t sender, Instant t, Bytes bytes) {
    if (pieces_.empty()) return lost(t, sender, bytes);
    std::optional<Bytestring> sent(std::in_place, bytes.begin(), bytes.end());
    for (Piece& piece : pieces_) {
        if (piece.sent_later)
            deferred_.push_back({t + piece.delay, sender, std::move(piece.bytes), sent});
        else
            push(sender, t, piece.delay, std::move(piece.bytes), sent);
        sent->clear();
    }
}

void ByteStream::push(std::size_t sender, Instant t, Duration delay, Bytestring bytes,
                      std::optional<Bytestring> sent) {
    Queue& queue = queue_of(sender);
    const auto count = static_cast<Duration::rep>(bytes.size());
    const Instant arrives = after(t, delay + options_.delay + options_.per_byte * count);
    const Instant earlier = queue.empty() ? arrives : queue.back().arrives;
    queue.push_back({t, std::max(arrives, earlier), std::move(bytes), 0, std::move(sent)});
}

void ByteStream::send_deferred(Instant t) {
    for (std::size_t i = 0; i < deferred_.size();) {
        if (deferred_[i].when > t) {
            ++i;
            continue;
        }
        Deferred later = std::move(deferred_[i]);
        deferred_.erase(deferred_.begin() + static_cast<std::ptrdiff_t>(i));
        if (swallows_ || ended_)
            lost(t, later.sender, later.bytes);
        else
            push(later.sender, t, {}, std::move(later.bytes), std::move(later.sent));
    }
}

}  // namespace takt::sim
