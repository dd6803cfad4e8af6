// The reads of a line: when each is due, and what asks for it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "devices/rate_limited_event.hpp"
#include "line/heap_optional.hpp"
#include "line/job_id.hpp"
#include "line/tables.hpp"
#include "reads/read_queue.hpp"
#include "reads/split.hpp"
#include "takt/bus/arbiter.hpp"
#include "takt/bus/health.hpp"
#include "takt/bus/release.hpp"

namespace takt::poll {

/// What a read that is sent serves.
enum class ReadCause : std::uint8_t {
    release,     ///< of its period
    repetition,  ///< it failed and was back in the queue
    trigger,
    probe,  ///< none of them: it is not due
};

/// The schedule of the reads of a line. A read is named by the index of its request.
///
/// A read is released on a grid of its period, whose origin is common to the line, and is due until it is
/// sent. A trigger asks for it at the rate of its token bucket; changes that come meanwhile are merged. A
/// read that failed goes back into the queue: a polled one is due at once, a triggered one waits again
/// without a new admission. A read that fails more often than its device allows is slowed down: it is probed
/// with the back-off of the device.
///
/// It reads the tables of the line (the plan, the job of the read, its last start, the health of its device)
/// and changes none of them. The caller chooses what is sent, and reports its start and end. A line with many
/// reads keeps them in a queue (ReadQueue). One owner, one thread; what it is given must outlive it.
/// Allocates while reads are added, in set_queue(), release_at_once(), and keep_due(); visit_ready() may.
class ReadSchedule {
public:
    ReadSchedule(const LineTables& tables, ArrivalCounter& arrivals) : tables_(tables), arrivals_(arrivals) {}

    // ---- the reads of a plan

    /// @param period   zero: as fast as the line allows, or not polled
    /// @param trigger  the admission, if it has one
    void add(std::size_t read, Duration period, std::optional<RateLimitedEvent> trigger);
    /// All reads were added. @param fewest  reads below which a comparison of all is as fast as a queue
    void set_queue(std::size_t fewest);
    [[nodiscard]] bool has_queue() const { return queue_ != nullptr; }

    // ---- releases

    /// The origin of the grid.
    void set_origin(Instant t) { origin_ = t; }
    /// The read follows the grid: its next release is the first one at or after `t`.
    void follow(Instant t, std::size_t read);
    /// A release at `t`, off the grid, if the read is polled.
    void release_at(Instant t, std::size_t read);
    /// Nothing is known of the device any more: its reads are not slowed down and follow the grid.
    void restart(Instant t, std::size_t device);
    /// The same, but they stay due when they were.
    void resume(std::size_t device);
    /// Reads each variable of the device once without waiting for the grid. Of reads that cover the same
    /// variables, the longest is released.
    void release_at_once(Instant t, std::size_t device, const SplitValues& splits);
    /// The release that waits is served by another read.
    void serve_release(Instant t, std::size_t read);
    /// Releases that passed while an earlier one was still waiting.
    [[nodiscard]] std::uint64_t skipped(std::size_t read) const { return reads_[read].skipped; }

    // ---- triggers

    /// A trigger changes. The reads that are pulled from now on have the same round.
    void next_change() { ++last_change_; }
    /// No effect while it is triggered already.
    void pull_trigger(Instant t, std::size_t read);
    void drop_trigger(std::size_t read) { reads_[read].triggered = false; }
    /// It waits for a trigger's read to be sent.
    [[nodiscard]] bool triggered(std::size_t read) const {
        return reads_[read].triggered && !reads_[read].in_flight;
    }
    /// Whether the bucket of the trigger admits it.
    [[nodiscard]] bool admit(Instant t, std::size_t read) { return reads_[read].trigger->event.admit(t); }
    [[nodiscard]] const RateLimitedEvent& event(std::size_t read) const {
        return reads_[read].trigger->event;
    }
    /// Without a bucket: whether it has taken its token of the line; else nullptr.
    [[nodiscard]] bool* line_token(std::size_t read);

    // ---- the choice

    /// It is polled and not in flight.
    [[nodiscard]] bool waits(std::size_t read) const;
    /// The earliest instant at which polling may send it.
    [[nodiscard]] Instant due(std::size_t read) const;
    /// The same without the back-off of a read that is slowed down.
    [[nodiscard]] Instant released(std::size_t read) const;
    /// The end of its back-off after exceptions 5 and 6.
    [[nodiscard]] Instant not_before(std::size_t read) const { return reads_[read].not_before; }
    [[nodiscard]] bool slowed(std::size_t read) const { return !reads_[read].health.answering(); }
    /// Its state, for the arbiter.
    [[nodiscard]] bus::PolledRead polled(std::size_t read) const;
    /// A read of the device with a period is due.
    [[nodiscard]] bool any_due(Instant t, std::size_t device) const;
    /// The read of the device that was sent least recently: it probes, because a read that the device never
    /// answers must not hide that it is back.
    [[nodiscard]] std::optional<std::size_t> oldest(std::size_t device) const;
    /// The start of the last read of the device.
    [[nodiscard]] Instant last_start(std::size_t device) const;

    // ---- the choice with a queue

    /// Updates the queue; call it before the following.
    void settle(Instant t, const bus::Arbiter& arbiter);
    /// When the next read of the device becomes due.
    [[nodiscard]] Instant next_wakeup(std::size_t device) const { return queue_->next_due(device); }
    /// A read of the device is due.
    [[nodiscard]] bool any_ready(std::size_t device) const { return queue_->first(device).has_value(); }
    /// Calls visit(read) for the due reads of the device, by priority, until it returns false.
    template <class Visit>
    void visit_ready(std::size_t device, const Visit& visit) {
        queue_->visit_due(device, visit);
    }

    // ---- transactions

    /// It is sent.
    /// @param by_trigger  else for its period, or as a probe
    ReadCause start(Instant t, std::size_t read, bool by_trigger);
    void ended(std::size_t read);
    /// Of the transaction in flight, or the last one.
    [[nodiscard]] bool by_trigger(std::size_t read) const { return reads_[read].by_trigger; }
    /// It goes back into the queue.
    void again(Instant t, std::size_t read);
    /// It was answered, possibly with an exception. @param busy  5 or 6: it is held back
    void answered(Instant t, std::size_t read, bool busy);
    /// It was not answered. @returns whether it is slowed down
    bool failed(Instant t, std::size_t read);
    /// The connection was closed before its response. @returns whether it may be sent again before it is due
    [[nodiscard]] bool lost_by_close(std::size_t read);
    /// A close that it met was not held against it; it may be once in a row.
    void spare(std::size_t read) { reads_[read].spared = true; }
    [[nodiscard]] bool spared(std::size_t read) const { return reads_[read].spared; }
    /// It is not sent before its next back-off has passed.
    void hold_back(Instant t, std::size_t read);
    /// That of the response that came last.
    [[nodiscard]] ReadRound round(std::size_t read) const;
    /// Parts of a value belong together if they have the same number: they were due in the same period of the
    /// value, or read by the same change of a trigger. With period 0 they are read one after the other and
    /// have no number.
    /// @param period  of the value; zero: that of the read
    [[nodiscard]] std::optional<std::int64_t> number_of(const ReadRound& round, std::size_t read,
                                                        Duration period) const;

    // ---- another plan, another poller

    /// The reads of the plan that is replaced; none is left. @param old  the tables with its requests
    [[nodiscard]] ReadSchedule take_reads(const LineTables& old);
    /// A read goes on where the same one of the old plan is.
    void carry(std::size_t read, const ReadSchedule& old, std::size_t old_read);
    /// `old_read` has the same trigger: if it is triggered, `read` is triggered too.
    void carry_trigger(std::size_t read, const ReadSchedule& old, std::size_t old_read);
    /// No variable is read later than by the old plan: if its next release is later, a release is added.
    void keep_due(Instant t, const ReadSchedule& old);
    /// The grid and the changes of triggers go on where those of another poller are.
    void take_over(const ReadSchedule& old);
    /// A read goes on where that of another poller is, without its triggers: they are pulled again.
    void take_over(std::size_t read, const ReadSchedule& old, std::size_t old_read);

private:
    struct Triggering {
        std::int64_t round = 0;  // number of the trigger's change
        RateLimitedEvent event;
        bool started = false;  // without a bucket: it has taken its token of the line
    };
    struct Read {
        bus::PeriodicRelease release{Duration::zero()};
        bus::Health health{1};
        bus::Backoff busy = bus::busy_backoff();
        Instant not_before = Instant::min();  // back-off after exceptions 5 and 6
        std::optional<Instant> retry;         // when a failed polled read came back into the queue
        HeapOptional<Triggering> trigger;     // if it has a read trigger
        Instant round = Instant::min();       // the instant of the grid that its values belong to
        std::uint64_t skipped = 0;
        std::uint8_t closes = 0;  // that it met in a row, at most 2
        bool spared = false;
        bool triggered = false;
        bool in_flight = false;
        bool by_trigger = false;
    };

    [[nodiscard]] const RequestRun& request(std::size_t read) const { return tables_.requests[read]; }
    [[nodiscard]] Duration period(std::size_t read) const;
    [[nodiscard]] Instant queued_since(std::size_t read) const;
    [[nodiscard]] Instant next_due(std::size_t read, Instant t) const;
    [[nodiscard]] std::optional<QueueEntry> entry(Instant t, std::size_t read,
                                                  const bus::Arbiter& arbiter) const;
    Read& change(std::size_t read);

    LineTables tables_;
    ArrivalCounter& arrivals_;
    std::vector<Read> reads_;  // by request
    std::unique_ptr<ReadQueue> queue_;
    Instant origin_;
    std::int64_t last_change_ = 0;
};

}  // namespace takt::poll
