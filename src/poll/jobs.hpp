// What a request of the plan does, and where it stands: its read half, its write half.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "boxed.hpp"
#include "read_back.hpp"
#include "takt/base/time.hpp"
#include "takt/bus/counters.hpp"
#include "takt/bus/health.hpp"
#include "takt/bus/release.hpp"
#include "takt/bus/token_bucket.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/model/project.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::poll {

using bus::Backoff;
using bus::busy_backoff;
using bus::Health;
using bus::PeriodicRelease;
using bus::PeriodMeter;

/// What waits in the queue because something happened: at most as often as its bucket allows. What comes
/// while it waits is done together with it.
struct Admittance {
    std::optional<bus::TokenBucket> bucket;
    std::optional<Duration> deadline;  // of what the bucket lets through
    bool admitted = false;
    std::uint64_t order = 0;  // among what was triggered and commanded

    Admittance() = default;
    explicit Admittance(const std::optional<model::Admission>& admission);

    /// Something happened while nothing waited.
    void arrive(Instant t, std::uint64_t next_order) {
        order = next_order;
        admitted = !bucket || bucket->admit(t);
    }
    /// Whether it is in the queue, or comes into it now.
    bool admit(Instant t) {
        if (!admitted) admitted = !bucket || bucket->admit(t);
        return admitted;
    }
};

/// How a trigger asks for a read.
struct Triggering {
    std::int64_t round = 0;  // which change of the trigger that was
    Admittance admittance;
};

/// The read half of a request of the plan.
struct ReadJob {
    wire::ReadRequest request;
    bus::AnswerShape shape;
    std::size_t rank = 0;  // among all jobs of the line, in the order of the plan
    Duration deadline{};   // relative to the release
    bool polled = false;   // by period
    PeriodicRelease release{Duration::zero()};
    PeriodMeter meter{Duration::zero()};
    Health health{1};
    Backoff busy = busy_backoff();
    Instant not_before = Instant::min();  // the device asked for patience
    std::optional<Instant> retry;         // a failed polled read is back in the queue since then
    Boxed<Triggering> trigger;            // where it has one
    bool triggered = false;
    unsigned refusals = 0;  // in a row, of a read that bridges gaps
    bool under_way = false;
    bool by_trigger = false;  // of the transaction under way
    Instant last_start = Instant::min();
    Instant round = Instant::min();  // what it reads belongs to the period with this instant

    [[nodiscard]] wire::PreparedRequest prepared() const;
    /// From when on polling may send it.
    [[nodiscard]] Instant polling_due() const {
        const Instant due = std::max(retry.value_or(release.next()), not_before);
        return health.answering() ? due : std::max(due, health.probe_at());
    }
    /// One that is slowed, though its device answers, waits from when it may be asked again and is due.
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

/// Where a read-modify-write stands.
struct Modify {
    bool reading = false;              // the read is under way
    std::optional<std::uint16_t> old;  // it was read: now the write, before anything else
};

/// The write half.
struct WriteJob {
    wire::Function function = wire::Function::write_multiple_registers;
    WriteKind kind = WriteKind::whole;
    std::vector<std::size_t> members;  // what is written: indices into Run::variables_
    bus::AnswerShape shape;
    std::size_t rank = 0;
    bool asked = false;        // by set(), or again after a failure of what was not asked by commands alone
    bool triggered = false;    // by its trigger
    std::size_t commands = 0;  // by so many commands that are not under way
    Admittance admittance;
    std::uint16_t failures = 0;
    Backoff busy = busy_backoff();
    Instant not_before = Instant::min();
    bool told_waiting = false;
    bool under_way = false;
    std::vector<std::size_t> sending;  // bits under way
    bool sent_asked = false;           // what is under way was asked for not by commands alone
    std::uint64_t sent_want = 0;       // Run::last_want_ when it was last sent,
    std::uint64_t settled_want = 0;    // and when what was last settled was
    Modify modify;
    std::unique_ptr<ReadBack> read_back;  // where some of it is verified
    bus::TimeStatistics read_time;        // of the read half, whose counters are also those of the writes

    [[nodiscard]] bool due() const { return asked || triggered || commands > 0; }
    /// It writes single bits of a register, and leaves the others as they are.
    [[nodiscard]] bool writes_bits() const { return kind == WriteKind::mask || kind == WriteKind::modify; }
};

/// The shape of the answer to a write of one register.
constexpr bus::AnswerShape written_shape(wire::Function function) {
    return {static_cast<std::uint8_t>(function), 5};
}

}  // namespace takt::poll
