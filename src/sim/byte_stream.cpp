#include "takt/sim/byte_stream.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"

namespace takt::sim {
namespace {

constexpr int kMaxStepsAtOneMoment = 10'000;

}  // namespace

ByteStream::ByteStream(Engine& client, serve::TcpConnection& server, const Options& options)
    : client_(client), server_(server), options_(options) {}

void ByteStream::set_link(Instant t, bool up) {
    now_ = std::max(now_, t);
    up_ = up;
    to_server_.clear();
    to_client_.clear();
    server_.on_link(now_, up);
    client_.on_link(now_, up);
    collect_all(now_);
}

void ByteStream::run_until(Instant t) {
    int steps = 0;
    for (Instant next = next_wakeup(); next <= t; next = next_wakeup()) {
        steps = next > now_ ? 0 : steps + 1;
        TAKT_ASSERT(steps < kMaxStepsAtOneMoment);
        now_ = std::max(now_, next);
        step(now_);
    }
    now_ = std::max(now_, t);
    collect_all(now_);
}

Instant ByteStream::next_wakeup() const {
    Instant next = std::min(client_.next_wakeup(), server_.next_wakeup());
    if (!to_client_.empty()) next = std::min(next, to_client_.front().arrives);
    if (!to_server_.empty() && server_.wants_bytes() > 0) next = std::min(next, to_server_.front().arrives);
    return next;
}

void ByteStream::step(Instant t) {
    to_server(t);
    to_client(t);
    if (server_.next_wakeup() <= t) server_.on_tick(t);
    if (client_.next_wakeup() <= t) client_.on_tick(t);
    collect_all(t);
    if (up_ && server_.close_reason() != serve::CloseReason::none) set_link(t, false);
}

void ByteStream::to_server(Instant t) {
    while (!to_server_.empty() && to_server_.front().arrives <= t && server_.wants_bytes() > 0) {
        Chunk& chunk = to_server_.front();
        const std::size_t count = std::min(chunk.bytes.size() - chunk.taken, server_.wants_bytes());
        server_.on_bytes(t, Bytes(chunk.bytes).subspan(chunk.taken, count));
        chunk.taken += count;
        if (chunk.taken == chunk.bytes.size()) arrived(0, to_server_);
    }
}

void ByteStream::to_client(Instant t) {
    while (!to_client_.empty() && to_client_.front().arrives <= t) {
        client_.on_bytes(t, to_client_.front().bytes);
        arrived(1, to_client_);
    }
}

void ByteStream::arrived(std::size_t sender, Queue& queue) {
    const Chunk& chunk = queue.front();
    if (observer_) observer_->on_transmission({sender, chunk.start, chunk.arrives, chunk.bytes, false});
    queue.pop_front();
}

void ByteStream::collect_all(Instant t) {
    collect(server_, to_client_, t);
    collect(client_, to_server_, t);
}

void ByteStream::collect(Engine& engine, Queue& queue, Instant t) {
    for (Bytes bytes = engine.transmit(t); !bytes.empty(); bytes = engine.transmit(t)) {
        if (!up_) continue;
        const auto count = static_cast<Duration::rep>(bytes.size());
        const Instant arrives = after(t, options_.delay + options_.per_byte * count);
        const Instant earlier = queue.empty() ? arrives : queue.back().arrives;
        queue.push_back({t, std::max(arrives, earlier), {bytes.begin(), bytes.end()}, 0});
    }
}

}  // namespace takt::sim
