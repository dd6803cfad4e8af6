// The state of a request of the plan: its read half and its write half.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "heap_optional.hpp"
#include "read_back.hpp"
#include "takt/base/time.hpp"
#include "takt/base/token_bucket.hpp"
#include "takt/bus/counters.hpp"
#include "takt/bus/health.hpp"
#include "takt/bus/release.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/model/project.hpp"
#include "takt/wire/prepared_request.hpp"
#include "write_progress.hpp"

namespace takt::poll {

using bus::Backoff;
using bus::busy_backoff;
using bus::Health;
using bus::PeriodicRelease;
using bus::PeriodMeter;

/// The admission of an event (a command, a trigger, a change) to the queue, at the rate of its token bucket.
/// Events that arrive while one waits are merged with it.
struct RateLimitedEvent {
    std::optional<TokenBucket> bucket;
    std::optional<Duration> deadline;  // of what the bucket admits
    bool admitted = false;
    std::uint64_t order = 0;  // of arrival, among commands and triggers

    RateLimitedEvent() = default;
    explicit RateLimitedEvent(const std::optional<model::RateLimit>& admission);

    /// An event arrives while none waits.
    void arrive(Instant t, std::uint64_t next_order) {
        order = next_order;
        admitted = !bucket || bucket->admit(t);
    }
    /// Whether it is in the queue, or enters it now.
    bool admit(Instant t) {
        if (!admitted) admitted = !bucket || bucket->admit(t);
        return admitted;
    }
};

/// A read by a trigger.
struct Triggering {
    std::int64_t round = 0;  // number of the trigger's change
    RateLimitedEvent event;
    bool started = false;  // without a bucket: it has taken its token of the line
};

/// The read half of a request of the plan.
struct ReadJob {
    wire::PreparedRead request;
    std::size_t rank = 0;  // among all jobs of the line, in the order of the plan
    Duration deadline{};   // relative to the release
    bool polled = false;   // by period
    PeriodicRelease release{Duration::zero()};
    PeriodMeter meter{Duration::zero()};
    Health health{1};
    Backoff busy = busy_backoff();
    Instant not_before = Instant::min();  // back-off after exceptions 5 and 6
    std::optional<Instant> retry;         // when a failed polled read came back into the queue
    HeapOptional<Triggering> trigger;     // if it has a read trigger
    bool triggered = false;
    unsigned refusals = 0;  // in a row, of a read across gaps
    bool in_flight = false;
    bool by_trigger = false;  // of the transaction in flight
    Instant last_start = Instant::min();
    Instant round = Instant::min();  // the instant of the grid that its values belong to

    [[nodiscard]] bus::AnswerShape shape() const { return bus::answer_shape(request.shape()); }
    /// The earliest instant at which polling may send it.
    [[nodiscard]] Instant polling_due() const {
        const Instant due = std::max(retry.value_or(release.next()), not_before);
        return health.answering() ? due : std::max(due, health.probe_at());
    }
    /// The start of its waiting time. A request that is slowed down waits from the end of its back-off.
    [[nodiscard]] Instant waits_since() const {
        return health.answering() ? retry.value_or(release.next()) : polling_due();
    }
};

/// How a request writes.
enum class WriteKind : std::uint8_t {
    whole,     // all members with 0x05, 0x06, 0x0F, 0x10
    mask,      // bits of one register with 0x16
    modify,    // bits of one register: read, then written with 0x06 or 0x10
    exchange,  // with 0x17, which reads too
};

/// The write half.
struct WriteJob {
    wire::Function function = wire::Function::write_multiple_registers;
    WriteKind kind = WriteKind::whole;
    std::vector<std::size_t> members;  // what is written: indices into Run::variables_
    bus::AnswerShape shape;
    std::size_t rank = 0;
    bool asked = false;      // by set(), or by a retry that is not for commands alone
    bool triggered = false;  // by its trigger
    RateLimitedEvent event;
    std::uint16_t failures = 0;
    Backoff busy = busy_backoff();
    Instant not_before = Instant::min();
    bool reported_waiting = false;
    WriteProgress progress;
    std::vector<std::size_t> sending;     // bits in flight
    bool sent_asked = false;              // the write in flight is not for commands alone
    bool sent_triggered = false;          // it, or a failed attempt before it, was asked for by its trigger
    bool started = false;                 // without a bucket: it has taken its token of the line
    std::uint64_t sent_want = 0;          // WrittenValues::last_number() when it was last sent
    std::uint64_t settled_want = 0;       // sent_want of the last write that ended
    std::unique_ptr<ReadBack> read_back;  // if some of its variables have `verify`
    bus::TimeStatistics read_time;        // of the read half; the other counters include the writes

    /// It changes single bits of a register and keeps the others.
    [[nodiscard]] bool writes_bits() const { return kind == WriteKind::mask || kind == WriteKind::modify; }
};

/// The shape of the answer to a write of one register.
constexpr bus::AnswerShape written_shape(wire::Function function) {
    return {static_cast<std::uint8_t>(function), 5};
}

}  // namespace takt::poll
