// Order of the calls: read -> on_bytes() -> transmit() until empty -> next_wakeup(). Bytes that the stream
// does not accept are stored, and transmit() is not called until they are written. At a wake-up the available
// bytes are read before on_tick(): a response that the system has received in time does not time out.
#include "loop/pump.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <span>
#include <utility>

namespace takt::line {
namespace {

constexpr std::size_t kReadAtOnce = 4096;

// FIN or RST. Other errors come from the network or the own computer.
bool is_closed_by_peer(const Error& error) {
    const auto number = error.numbers[0];
    return error.code == Code::connection_lost && (number == 0 || number == ECONNRESET || number == EPIPE);
}

}  // namespace

Pump::Pump(Loop& loop, ByteStream& stream, Engine& engine, PumpOptions options, PumpEnd on_end)
    : stream_(stream),
      engine_(engine),
      options_(std::move(options)),
      on_end_(std::move(on_end)),
      watch_(
          loop, stream.fd(), [this] { readable(); }, [this] { writable(); }),
      timer_(loop, [this](Instant t) { tick(t); }),
      loop_(loop) {}

Pump::~Pump() = default;

void Pump::start() {
    running_ = true;
    engine_.on_link(now(), true);
    if (!watch_.ok()) return end(Error{Code::io_failed, "epoll", {ENOSPC, 0, 0}});
    service();
}

void Pump::poke() {
    if (running_) service();
}

void Pump::readable() {
    if (running_ && readable_bytes() > 0 && receive()) service();
}

// Returns false if the stream failed; the pump may then be destroyed.
bool Pump::receive() {
    std::array<std::uint8_t, kReadAtOnce> buffer;  // NOLINT(*-member-init): filled by read()
    const auto got = stream_.read(std::span(buffer).first(readable_bytes()));
    const Instant t = now();
    if (!got && !is_half_closed(got.error())) {
        end(got.error());
        return false;
    }
    if (!got) {
        input_end_ = got.error();
        if (options_.input_ended) options_.input_ended();
        return true;
    }
    counters_.bytes_read += *got;
    if (*got > 0) engine_.on_bytes(t, Bytes(buffer.data(), *got));
    return true;
}

// The end of the stream without an error: the peer may still read.
bool Pump::is_half_closed(const Error& error) const {
    return options_.drained && error.code == Code::connection_lost && error.numbers[0] == 0;
}

void Pump::writable() {
    if (!running_) return;
    const auto waiting = std::exchange(pending_, {});
    if (!write(waiting)) return;
    if (pending_.empty()) limit_waiting(false);
    service();
}

void Pump::tick(Instant t) {
    if (!running_) return;
    while (t < wakeup_) t = now();
    // The event of these bytes may come after the timer: the thread was stopped between the two, or more
    // descriptors were ready than one epoll_wait() returns. `t` is from before the read, so bytes that arrive
    // after it are late.
    const auto before = counters_.bytes_read;
    if (readable_bytes() > 0 && !receive()) return;
    if (counters_.bytes_read != before) t = now();
    engine_.on_tick(t);
    service();
}

void Pump::service() {
    while (pending_.empty()) {
        const Bytes bytes = engine_.transmit(now());
        if (bytes.empty()) break;
        if (!write(bytes)) return;
    }
    if (pending_.empty() && options_.written_out) options_.written_out();
    if (pending_.empty() && options_.finished && options_.finished()) return end(std::nullopt);
    if (pending_.empty() && input_end_ && options_.drained()) return end(input_end_);
    arm();
}

// Returns false if the stream failed; the pump may then be destroyed.
bool Pump::write(Bytes bytes) {
    const auto taken = stream_.write(bytes);
    if (!taken) {
        end(taken.error());
        return false;
    }
    counters_.bytes_written += *taken;
    if (*taken > 0 && options_.written) options_.written(now(), *taken);
    if (*taken < bytes.size()) {
        pending_.assign(bytes.begin() + static_cast<std::ptrdiff_t>(*taken), bytes.end());
        watch_.want_write();
        if (options_.write_limit > Duration::zero()) limit_waiting(true);
    }
    return true;
}

void Pump::limit_waiting(bool waiting) {
    if (!waiting) {
        if (stalled_) stalled_->set(kNever);
        return;
    }
    if (!stalled_)
        stalled_ = std::make_unique<Timer>(loop_, [this](Instant) {
            end(Error{Code::timed_out, "write", {options_.write_limit / std::chrono::milliseconds(1), 0, 0}});
        });
    if (stalled_->when() == kNever) stalled_->set(after(now(), options_.write_limit));
}

std::size_t Pump::readable_bytes() const {
    if (input_end_ || (options_.pause_reading && !pending_.empty())) return 0;
    return options_.wants_bytes ? std::min(options_.wants_bytes(), kReadAtOnce) : kReadAtOnce;
}

void Pump::arm() {
    if (readable_bytes() > 0) watch_.want_read();
    Instant wakeup = engine_.next_wakeup();
    if (stream_.has_buffered() && readable_bytes() > 0) wakeup = std::min(wakeup, now());
    // While output is pending the engine may ask to be woken immediately. The limit prevents a busy loop.
    constexpr Duration kWhilePending = std::chrono::milliseconds(1);
    if (!pending_.empty()) wakeup = std::max(wakeup, now() + kWhilePending);
    wakeup_ = wakeup;
    // A punctual pump sleeps less, and spins for the rest.
    timer_.set(options_.punctual && wakeup != kNever ? wakeup - kTimerLateness : wakeup);
}

// The owner may destroy the pump in on_end_, so no member is used after the call.
void Pump::end(const std::optional<Error>& why) {
    running_ = false;
    timer_.set(kNever);
    limit_waiting(false);
    const Instant t = now();
    if (options_.reopens && (!why || is_closed_by_peer(*why)))
        engine_.on_close(t);
    else
        engine_.on_link(t, false);
    const auto on_end = std::move(on_end_);
    on_end(t, why);
}

}  // namespace takt::line
