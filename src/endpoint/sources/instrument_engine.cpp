// Three levels. Phase: down; starting and restoring; start_failed; ready. Job: what is sent in the phase, an
// exchange, a start command, a setting or a command; the two last have a second step, the reading back. Wire:
// resting until the job sends; awaiting an answer; settling after a time-out, until the line is silent.
// Without requests: searching for the start of an answer, then in step.
#include "takt/endpoint/instrument_engine.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "sources/command_text.hpp"
#include "takt/base/assert.hpp"

namespace takt::endpoint {
namespace {

constexpr int kLongestSettling = 10;  // limit of the wait for silence, in time-outs

const value::Value* value_in(const Measurements& found) {
    const auto value = std::ranges::find(found, std::string_view("value"), &Measured::name);
    return value == found.end() ? nullptr : &value->value;
}

const model::AnswerFormat* pointer(const std::optional<model::AnswerFormat>& format) {
    return format ? &*format : nullptr;
}

}  // namespace

std::string_view name(InstrumentState state) {
    constexpr std::array<std::string_view, 5> kNames{"ready", "starting", "start_failed", "silent", "down"};
    return kNames[static_cast<std::size_t>(state)];
}

InstrumentEngine::InstrumentEngine(const model::Instrument& settings)
    : settings_(settings), confirmed_(settings.commands.size()) {
    for (const auto& exchange : settings.exchanges)
        for (const auto name : exchange.answer.names()) readings_.push_back({name, {}});
    reset_.expect(pointer(settings.reset));
    buffer_.reserve(kMostAnswer);
}

const Reading& InstrumentEngine::reading(std::string_view measurement) const {
    const auto found = std::ranges::find(readings_, measurement, &Named::name);
    TAKT_ASSERT(found != readings_.end());
    return found->reading;
}

InstrumentState InstrumentEngine::state() const {
    switch (phase_) {
        case Phase::down: return InstrumentState::down;
        case Phase::starting:
        case Phase::restoring: return InstrumentState::starting;
        case Phase::start_failed: return InstrumentState::start_failed;
        case Phase::ready: break;
    }
    return silent_ ? InstrumentState::silent : InstrumentState::ready;
}

void InstrumentEngine::notify(Instant t, const InstrumentEvent& event) const {
    if (observer_) observer_(t, event);
}

// ---- start

bool InstrumentEngine::has_start() const {
    return !settings_.start.empty() ||
           std::ranges::any_of(confirmed_, [](const auto& value) { return value.has_value(); });
}

void InstrumentEngine::on_link(Instant t, bool up) {
    last_bytes_ = t;
    interrupt(t);
    if (up) return begin_start(t);
    if (phase_ != Phase::down) down_since_ = t;
    phase_ = Phase::down;
    wire_ = Wire::resting;
    buffer_.clear();
}

void InstrumentEngine::begin_start(Instant t) {
    interrupt(t);
    phase_ = has_start() ? Phase::starting : Phase::ready;
    wire_ = Wire::resting;
    ready_at_ = t;
    start_ = command_ = restored_ = 0;
    exchange_ = 0;
    round_ = settings_.is_asked() ? t : kNever;
    unanswered_ = 0;
    silent_ = was_command_ = in_step_ = false;
    buffer_.clear();
    reset_.clear();
}

/// Ends the job. A setting of a client stays in the queue, to be sent after the start.
void InstrumentEngine::interrupt(Instant t) {
    const Job job = std::exchange(job_, Job::none);
    if (job == Job::command && !command().restore) {
        conclude(t, queue_.front(), WriteResult::no_answer);
        queue_.pop_front();
    }
}

// An instrument that restarts may send more than the line of its reset: only silence ends that.
void InstrumentEngine::on_reset_line(Instant t) {
    ++counters_.resets;
    notify(t, {.kind = InstrumentEvent::Kind::reset_line});
    begin_start(t);
    settle(t);
}

void InstrumentEngine::fail_start(Instant t, WriteResult why) {
    const bool setting = job_ == Job::setting;
    ++counters_.failed_starts;
    phase_ = Phase::start_failed;
    notify(t, {.kind = setting ? InstrumentEvent::Kind::restore_failed : InstrumentEvent::Kind::start_failed,
               .number = setting ? command_ : start_,
               .result = why});
    job_ = Job::none;
    ready_at_ = after(t, settings_.start_retry);
}

// ---- received bytes

void InstrumentEngine::on_bytes(Instant t, Bytes bytes) {
    const bool paused = t - last_bytes_ > settings_.timeout;
    last_bytes_ = t;
    if (phase_ == Phase::down) return;
    for (const auto byte : bytes) take_one(t, byte);
    counters_.strange += answer_.take_strange();
    if (wire_ == Wire::awaiting && t >= due_) on_tick(t);  // bytes first: they may have waited to be read
    if (wire_ == Wire::settling) due_ = std::min(after(t, settings_.timeout), settled_);  // not silent yet
    if (settings_.is_asked() || phase_ != Phase::ready) return;
    if (paused) {
        buffer_.clear();
        in_step_ = true;
    }
    take_sent(t, bytes);
}

void InstrumentEngine::take_one(Instant t, std::uint8_t byte) {
    if (wire_ == Wire::awaiting) {
        if (const auto found = answer_.take(byte)) {
            reset_.clear();
            return on_answer(t, *found);
        }
        if (refused_.take(byte)) {
            reset_.clear();
            return on_refused(t);
        }
    }
    if (reset_.take(byte)) on_reset_line(t);
}

/// Processes the bytes in pieces, so that the buffer stays bounded during a flood.
void InstrumentEngine::take_sent(Instant t, Bytes bytes) {
    while (!bytes.empty()) {
        const auto count = std::min(bytes.size(), kMostAnswer - buffer_.size());
        buffer_.insert(buffer_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count));
        bytes = bytes.subspan(count);
        while (!buffer_.empty() && take_one_sent(t)) {}
        if (buffer_.size() < kMostAnswer) continue;
        ++counters_.strange;
        in_step_ = false;
        buffer_.clear();
    }
}

/// Takes one answer, or skips bytes that belong to none. @returns false if more bytes are needed
bool InstrumentEngine::take_one_sent(Instant t) {
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

void InstrumentEngine::drop(std::size_t count) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(count));
}

void InstrumentEngine::keep(Instant t, const Measurements& found) {
    ++counters_.answers;
    for (const auto& [name, value] : found) {
        auto& reading = std::ranges::find(readings_, name, &Named::name)->reading;
        reading = {value, t, false};
    }
}

// ---- outcomes of requests

void InstrumentEngine::on_answer(Instant t, const Measurements& found) {
    unanswered_ = 0;
    wire_ = Wire::resting;
    ready_at_ = t;
    if (job_ == Job::exchange) return on_exchange(t, found);
    ++counters_.answers;
    ready_at_ = after(t, confirmation().pause);
    attempts_ = 0;
    if (writes()) return on_write_answer(t, found);
    job_ = Job::none;
    ++start_;
}

void InstrumentEngine::on_exchange(Instant t, const Measurements& found) {
    // It may have restarted meanwhile: the measurement may be one of its factory settings.
    if (std::exchange(silent_, false)) {
        notify(t, {.kind = InstrumentEvent::Kind::silence_ended});
        if (has_start()) {
            ++counters_.resets;
            ++counters_.answers;
            return begin_start(t);
        }
    }
    keep(asked_, found);
    next_exchange(t);
}

void InstrumentEngine::next_exchange(Instant t) {
    job_ = Job::none;
    exchange_ = (exchange_ + 1) % settings_.exchanges.size();
    round_ = exchange_ == 0 ? std::max(after(round_begun_, settings_.every), t) : t;
}

void InstrumentEngine::on_write_answer(Instant t, const Measurements& found) {
    const auto* const value = value_in(found);
    if (value != nullptr && value_text(command(), *value) != text())
        return finish_write(t, WriteResult::differs);
    if (step_ == Step::read_back || !command().read_back) return finish_write(t, WriteResult::done);
    step_ = Step::read_back;
}

void InstrumentEngine::on_refused(Instant t) {
    unanswered_ = 0;
    wire_ = Wire::resting;
    ready_at_ = after(t, confirmation().pause);
    ++counters_.answers;
    if (writes()) return finish_write(t, WriteResult::refused);
    ready_at_ = std::max(ready_at_, after(t, confirmation().timeout));
    if (++attempts_ >= confirmation().attempts) fail_start(t, WriteResult::refused);
}

void InstrumentEngine::on_timeout(Instant t) {
    ++counters_.timeouts;
    settle(t);
    if (phase_ == Phase::ready && settings_.is_asked() && settings_.silent_after > 0 &&
        ++unanswered_ == settings_.silent_after) {
        silent_ = true;
        notify(t, {.kind = InstrumentEvent::Kind::silent, .number = unanswered_});
    }
    if (job_ == Job::exchange) {
        for (const auto name : settings_.exchanges[exchange_].answer.names())
            std::ranges::find(readings_, name, &Named::name)->reading.fails = true;
        return next_exchange(t);
    }
    if (++attempts_ < confirmation().attempts) return;
    if (job_ == Job::command) return finish_write(t, WriteResult::no_answer);
    wire_ = Wire::resting;
    fail_start(t, WriteResult::no_answer);
}

// An instrument that sends by itself is never silent, so its late answer has one time-out to come.
void InstrumentEngine::settle(Instant t) {
    wire_ = Wire::settling;
    due_ = after(t, settings_.timeout);
    settled_ = settings_.is_asked() ? after(t, kLongestSettling * settings_.timeout) : due_;
}

// ---- commands

/// Whether a command would surely expire.
bool InstrumentEngine::is_deaf(Instant t, Duration expires) {
    if (phase_ != Phase::down) return silent_ || phase_ == Phase::start_failed;
    if (!down_since_) down_since_ = t;
    return t - *down_since_ >= expires;
}

Result<void> InstrumentEngine::submit(Instant t, std::size_t command, std::string text, Done done) {
    expire(t);
    const Duration expires = settings_.commands[command].expires;
    if (is_deaf(t, expires)) {
        ++counters_.unanswered;
        notify(t, {InstrumentEvent::Kind::write_failed, command, WriteResult::no_answer, text});
        return fail(Code::timed_out);
    }
    if (queue_.size() >= kMostCommands) {
        ++counters_.busy;
        return fail(Code::queue_full, static_cast<std::int64_t>(kMostCommands));
    }
    queue_.push_back({command, std::move(text), std::move(done), after(t, expires), false});
    return {};
}

const std::string& InstrumentEngine::text() const {
    return job_ == Job::command ? queue_.front().text : *confirmed_[command_];
}

const model::Confirmation& InstrumentEngine::confirmation() const {
    return job_ == Job::start ? settings_.start[start_].confirmation : command().confirmation;
}

void InstrumentEngine::finish_write(Instant t, WriteResult result) {
    const Job job = std::exchange(job_, Job::none);
    if (job == Job::command) {
        Pending finished = std::move(queue_.front());
        queue_.pop_front();
        if (result == WriteResult::done && command().restore) confirmed_[command_] = finished.text;
        return conclude(t, finished, result);
    }
    if (result == WriteResult::done) {
        ++counters_.restored;
        ++restored_;
    } else {
        const auto dropped = std::exchange(confirmed_[command_], std::nullopt);
        notify(t, {InstrumentEvent::Kind::setting_dropped, command_, result, *dropped});
    }
    ++command_;
}

/// Gives the result, unless the command has expired before.
void InstrumentEngine::conclude(Instant t, Pending& pending, WriteResult result) {
    if (pending.expired) return;
    pending.expired = true;
    switch (result) {
        case WriteResult::done: ++counters_.written; break;
        case WriteResult::refused:
        case WriteResult::differs: ++counters_.refused; break;
        case WriteResult::no_answer:
        case WriteResult::expired: ++counters_.unanswered; break;
    }
    if (result != WriteResult::done)
        notify(t, {InstrumentEvent::Kind::write_failed, pending.command, result, pending.text});
    if (const auto done = std::exchange(pending.done, {})) done(result);
}

/// The command in flight stays: its answer may still tell which value the instrument has.
void InstrumentEngine::expire(Instant t) {
    for (auto& pending : queue_)
        if (t >= pending.expires) conclude(t, pending, WriteResult::expired);
    const auto waiting = queue_.begin() + (job_ == Job::command ? 1 : 0);
    queue_.erase(std::remove_if(waiting, queue_.end(), [](const Pending& p) { return p.expired; }),
                 queue_.end());
}

// ---- time

void InstrumentEngine::on_tick(Instant t) {
    expire(t);
    if (wire_ == Wire::resting || t < due_) return;
    if (std::exchange(wire_, Wire::resting) == Wire::awaiting)
        on_timeout(t);
    else if (job_ == Job::command && queue_.front().expired)
        finish_write(t, WriteResult::no_answer);  // no further attempt
    ready_at_ = std::max(ready_at_, t);
}

/// Chooses the next job, if one is due.
void InstrumentEngine::choose(Instant t) {
    if (phase_ == Phase::start_failed) begin_start(t);
    if (phase_ == Phase::starting) {
        if (start_ < settings_.start.size()) {
            job_ = Job::start;
            attempts_ = 0;
            return;
        }
        phase_ = Phase::restoring;
        command_ = 0;
    }
    if (phase_ == Phase::restoring) {
        while (command_ < confirmed_.size() && !confirmed_[command_]) ++command_;
        if (command_ < confirmed_.size()) {
            job_ = Job::setting;
            step_ = Step::write;
            attempts_ = 0;
            return;
        }
        phase_ = Phase::ready;
        ++counters_.starts;
        notify(t, {.kind = InstrumentEvent::Kind::ready, .number = restored_});
    }
    choose_ready(t);
}

// A command goes before an exchange, but not twice in a row, so that measurements stay fresh.
void InstrumentEngine::choose_ready(Instant t) {
    expire(t);
    const bool exchange_due = t >= round_;
    if (!queue_.empty() && !silent_ && !(was_command_ && exchange_due)) {
        job_ = Job::command;
        step_ = Step::write;
        command_ = queue_.front().command;
        attempts_ = 0;
        was_command_ = true;
    } else if (exchange_due) {
        job_ = Job::exchange;
        was_command_ = false;
    }
}

Bytes InstrumentEngine::transmit(Instant t) {
    if (phase_ == Phase::down || wire_ != Wire::resting || t < ready_at_) return {};
    if (job_ == Job::none) choose(t);
    switch (job_) {
        case Job::none: return {};
        case Job::exchange: {
            if (exchange_ == 0) round_begun_ = t;
            const auto& exchange = settings_.exchanges[exchange_];
            return send(t, exchange.request, &exchange.answer, nullptr, settings_.timeout);
        }
        case Job::start: {
            const auto& [_, request, confirmation] = settings_.start[start_];
            return send(t, request, pointer(confirmation.answer), pointer(confirmation.refused),
                        confirmation.timeout);
        }
        case Job::setting:
        case Job::command: break;
    }
    const auto& [answer, refused, timeout, pause, attempts] = command().confirmation;
    if (step_ == Step::read_back)
        return send(t, command().read_back->request, &command().read_back->answer, nullptr, timeout);
    return send(t, command_bytes(command(), text()), pointer(answer), pointer(refused), timeout);
}

Bytes InstrumentEngine::send(Instant t, std::string bytes, const model::AnswerFormat* answer,
                             const model::AnswerFormat* refused, Duration timeout) {
    sent_ = std::move(bytes);
    asked_ = t;
    ++counters_.requests;
    answer_.expect(answer);
    refused_.expect(refused);
    if (answer != nullptr) {
        wire_ = Wire::awaiting;
        due_ = after(t, timeout);
    } else {
        ready_at_ = after(t, confirmation().pause);
        if (writes()) {
            step_ = Step::read_back;
        } else {
            job_ = Job::none;
            ++start_;
        }
    }
    return {reinterpret_cast<const std::uint8_t*>(sent_.data()), sent_.size()};
}

Instant InstrumentEngine::next_wakeup() const {
    Instant next = kNever;
    if (phase_ != Phase::down) {
        if (wire_ != Wire::resting)
            next = due_;
        else if (phase_ != Phase::ready || job_ != Job::none || (!queue_.empty() && !silent_))
            next = ready_at_;
        else if (round_ != kNever)
            next = std::max(ready_at_, round_);
    }
    return std::min(next, next_expiry());
}

Instant InstrumentEngine::next_expiry() const {
    Instant next = kNever;
    for (const auto& pending : queue_)
        if (!pending.expired) next = std::min(next, pending.expires);
    return next;
}

}  // namespace takt::endpoint
