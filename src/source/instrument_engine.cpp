// States: idle until the next round; asking (a request is in flight until an answer or the time-out);
// settling (after a time-out, until the line is silent). Without requests: searching for the start of an
// answer, then in step.
#include "takt/source/instrument_engine.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"

namespace takt::source {
namespace {

constexpr int kLongestSettling = 10;  // limit of the wait for silence, in time-outs

}  // namespace

InstrumentEngine::InstrumentEngine(const model::Instrument& settings) : settings_(settings) {
    for (const auto& exchange : settings.exchanges)
        for (const auto name : exchange.answer.names()) readings_.push_back({name, {}});
    buffer_.reserve(kMostAnswer);
}

const Reading& InstrumentEngine::reading(std::string_view measurement) const {
    const auto found = std::ranges::find(readings_, measurement, &Named::name);
    TAKT_ASSERT(found != readings_.end());
    return found->reading;
}

void InstrumentEngine::on_link(Instant t, bool up) {
    buffer_.clear();
    in_step_ = false;
    exchange_ = 0;
    state_ = up ? State::resting : State::down;
    due_ = up && settings_.is_asked() ? t : kNever;
    last_bytes_ = t;
}

void InstrumentEngine::on_bytes(Instant t, Bytes bytes) {
    if (state_ == State::awaiting && t >= due_) on_tick(t);
    const bool talks = !settings_.is_asked();
    const bool paused = t - last_bytes_ > settings_.timeout;
    last_bytes_ = t;
    if (talks && state_ != State::down) {
        if (paused) {
            buffer_.clear();
            in_step_ = true;
        }
        take(t, bytes);
    } else if (state_ == State::awaiting) {
        take(t, bytes);
    } else if (state_ == State::settling) {
        due_ = std::min(after(t, settings_.timeout), settled_);  // not silent yet
    }
}

/// Processes the bytes in pieces, so that the buffer stays bounded during a flood.
void InstrumentEngine::take(Instant t, Bytes bytes) {
    while (!bytes.empty() && (state_ == State::awaiting || !settings_.is_asked())) {
        const auto count = std::min(bytes.size(), kMostAnswer - buffer_.size());
        buffer_.insert(buffer_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count));
        bytes = bytes.subspan(count);
        if (settings_.is_asked())
            hear_answer(t);
        else
            hear_talk(t);
        if (buffer_.size() < kMostAnswer) continue;
        ++counters_.strange;
        in_step_ = false;
        buffer_.clear();
    }
}

void InstrumentEngine::hear_answer(Instant t) {
    const auto& format = current().answer;
    while (true) {
        const auto found = find_answer(format, buffer_);
        drop(found.skip);
        if (found.answer == 0) return;
        const auto measured = read_answer(format, Bytes(buffer_).first(found.answer));
        if (measured) {
            keep(asked_, *measured);
            return next_exchange(t);
        }
        ++counters_.strange;
        // Text: drop the line. Binary: drop only the first byte, because an answer may begin behind it.
        drop(format.until.empty() ? 1 : found.answer);
    }
}

void InstrumentEngine::hear_talk(Instant t) {
    while (!buffer_.empty() && hear_one(t)) {}
}

/// Takes one answer, or skips bytes that belong to none. @returns false if more bytes are needed
bool InstrumentEngine::hear_one(Instant t) {
    std::size_t least = buffer_.size() + 1;  // bytes that no exchange can still use
    for (const auto& exchange : settings_.exchanges) {
        const auto& format = exchange.answer;
        const auto found = find_answer(format, buffer_);
        if (found.answer == 0) {
            least = std::min(least, found.skip);
            continue;
        }
        const bool marked = !format.begins.empty() || format.checksum != model::Checksum::none;
        const bool whole = in_step_ || (format.until.empty() && marked);
        const auto measured =
            whole ? read_answer(format, Bytes(buffer_).subspan(found.skip, found.answer)) : std::nullopt;
        if (measured) {
            keep(t, *measured);
            drop(found.skip + found.answer);
            in_step_ = true;
            return true;
        }
        least = std::min(least, format.until.empty() ? found.skip + 1 : found.answer);
    }
    if (least == 0 || least > buffer_.size()) return false;
    if (in_step_) ++counters_.strange;
    const bool texts = !settings_.exchanges.front().answer.until.empty();
    drop(least);
    in_step_ = texts;  // after a line end the next byte begins an answer
    return true;
}

void InstrumentEngine::keep(Instant t, const Measurements& found) {
    ++counters_.answers;
    for (const auto& [name, value] : found) {
        auto& reading = std::ranges::find(readings_, name, &Named::name)->reading;
        reading = {value, t, false};
    }
}

void InstrumentEngine::fail_exchange() {
    ++counters_.timeouts;
    for (const auto name : current().answer.names())
        std::ranges::find(readings_, name, &Named::name)->reading.fails = true;
}

void InstrumentEngine::drop(std::size_t count) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(count));
}

void InstrumentEngine::next_exchange(Instant t) {
    buffer_.clear();
    state_ = State::resting;
    exchange_ = (exchange_ + 1) % settings_.exchanges.size();
    due_ = exchange_ == 0 ? std::max(after(round_, settings_.every), t) : t;
}

void InstrumentEngine::settle(Instant t) {
    state_ = State::settling;
    due_ = after(t, settings_.timeout);
    settled_ = after(t, kLongestSettling * settings_.timeout);
}

void InstrumentEngine::on_tick(Instant t) {
    if (t < due_) return;
    if (state_ == State::awaiting) {
        fail_exchange();
        buffer_.clear();
        settle(t);
    } else if (state_ == State::settling) {
        next_exchange(t);
    }
}

Bytes InstrumentEngine::transmit(Instant t) {
    if (state_ != State::resting || t < due_) return {};
    if (exchange_ == 0) round_ = t;
    state_ = State::awaiting;
    asked_ = t;
    due_ = after(t, settings_.timeout);
    buffer_.clear();
    ++counters_.requests;
    const auto& request = current().request;
    return {reinterpret_cast<const std::uint8_t*>(request.data()), request.size()};
}

Instant InstrumentEngine::next_wakeup() const {
    return state_ == State::down ? kNever : due_;
}

}  // namespace takt::source
