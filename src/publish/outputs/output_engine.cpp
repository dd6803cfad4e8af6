#include "takt/publish/output_engine.hpp"

#include <algorithm>
#include <utility>

#include "outputs/delivery_pace.hpp"
#include "outputs/output_log.hpp"
#include "takt/base/assert.hpp"

namespace takt::publish {
namespace {

constexpr store::DestinationId kDestination{0};

}  // namespace

OutputEngine::OutputEngine(Options options, std::unique_ptr<OutputWork> work)
    : options_(std::move(options)),
      queue_(options_.queue_bytes),
      work_(std::move(work)),
      output_log_(std::make_unique<OutputLog>(options_.log)),
      pace_(std::make_unique<DeliveryPace>()) {
    TAKT_ASSERT(options_.open_storage && options_.wall_ns && work_);
    status_.name = options_.name;
}

OutputEngine::~OutputEngine() = default;

OutputStatus OutputEngine::status() const {
    const std::lock_guard lock(status_mutex_);
    auto status = status_;
    const auto pushed = queue_.pushed();
    const auto lost = pushed.lost - status_lost_;
    status.samples.sampled += pushed.samples - status_taken_;
    status.samples.waiting += pushed.samples - status_taken_ - lost;
    status.samples.dropped += lost;
    status.lost += lost;
    status.gaps += lost > 0 ? 1 : 0;
    status.journal.buffer_samples += pushed.samples - status_taken_;
    return status;
}

void OutputEngine::step(Instant now) {
    if (!journal_) try_to_open(now);
    if (journal_) work(now);
    if (end_ != End::no) advance_stop(now);
    publish_status(now);
}

Instant OutputEngine::next_wakeup() const {
    if (end_ == End::durable) return {};
    if (!journal_) return open_again_;
    return std::min({journal_->next_wakeup(), work_->next_wakeup(), stop_until_});
}

std::span<const int> OutputEngine::descriptors() const {
    return journal_ ? work_->descriptors() : std::span<const int>();
}

void OutputEngine::on_state_changed(Instant now) {
    if (journal_) work_->on_state_changed(now);
}

bool OutputEngine::finished(Instant now) const {
    if (end_ == End::no) return false;
    return !journal_ || (end_ == End::leaving && work_->stopped()) || now >= stop_until_;
}

void OutputEngine::close(Instant now) {
    if (journal_) {
        take_queue(now);
        static_cast<void>(journal_->close(now));  // an error is in the status of the journal
    }
    publish_status(now);
    const std::lock_guard lock(status_mutex_);
    status_.state = OutputState::ended;
}

// What a destination takes at the moment, it gets to the last sample. The rest waits for the next start. The
// time that the disk needs is not the destination's: its limit begins with the step after the closing one.
void OutputEngine::advance_stop(Instant now) {
    if (!journal_ || end_ == End::leaving) return;
    if (end_ == End::asked) {
        take_queue(now);
        // An error is in the status of the journal, and it is tried again at the end.
        static_cast<void>(journal_->close(now));
        work_->work(now);
        end_ = End::durable;
        return;
    }
    if (end_ == End::durable) {
        stop_until_ = now + options_.stop_limit;
        end_ = End::delivering;
    }
    const bool more =
        work_->takes_records() && journal_->acknowledged(kDestination) < journal_->status().durable_sequence;
    if (more && now < stop_until_ - options_.stop_limit / 2) return;
    work_->stop(now);
    work_->work(now);
    end_ = End::leaving;
}

Result<store::Journal> OutputEngine::open(Instant now) {
    if (!storage_) {
        TAKT_TRY(storage_, options_.open_storage());
    }
    const std::string_view destinations[] = {options_.name};
    return store::Journal::open(*storage_, options_.journal, destinations, now, options_.wall_ns(now));
}

void OutputEngine::try_to_open(Instant now) {
    if (now < open_again_) return;
    open_again_ = now + kOpenAgain;
    auto opened = open(now);
    if (!opened) {
        open_failure_ = opened.error();
        return;
    }
    open_failure_.reset();
    journal_.emplace(*std::move(opened));
    const auto before = journal_->counters(kDestination);
    appended_before_ = before.appended;
    dropped_before_ = before.dropped;
    work_->begin(now, *journal_, kDestination);
}

void OutputEngine::take_queue(Instant now) {
    while (const auto queued = queue_.take()) {
        taken_ += queued->samples;
        if (queued->payload.empty()) taken_lost_ += queued->samples;
        if (queued->payload.empty())
            journal_->append_loss(now, {.samples = queued->samples,
                                        .first_wall_ns = queued->first_wall_ns,
                                        .last_wall_ns = queued->last_wall_ns,
                                        .buffer_full = queued->queue_full});
        else
            // A full buffer is counted by the journal, and a payload has a size that it takes.
            static_cast<void>(journal_->append(now, {.samples = queued->samples,
                                                     .wall_ns = queued->last_wall_ns,
                                                     .monotonic_ns = queued->last_monotonic_ns,
                                                     .payload = queued->payload,
                                                     .oldest_wall_ns = queued->first_wall_ns}));
    }
}

void OutputEngine::work(Instant now) {
    take_queue(now);
    if (journal_->next_wakeup() <= now) journal_->on_tick(now, options_.wall_ns(now));
    work_->work(now);
    if (!work_->take_retained_request()) return;
    queue_.request_retained();
    if (options_.wake_sampler) options_.wake_sampler();
}

void OutputEngine::find_oldest(Instant now) {
    status_at_ = now + std::chrono::seconds(1);
    oldest_ns_.reset();
    if (journal_->counters(kDestination).waiting > 0) oldest_ns_ = journal_->oldest_waiting_ns(kDestination);
}

void OutputEngine::publish_status(Instant now) {
    OutputStatus status;
    status.name = options_.name;
    status.journal_failure = open_failure_;
    status.samples.sampled = appended_before_ + taken_;
    if (journal_) {
        const auto counters = journal_->counters(kDestination);
        status.samples.delivered = counters.delivered;
        status.samples.dropped = counters.dropped;
        status.samples.waiting = counters.waiting;
        status.lost = counters.dropped - std::min(counters.dropped, dropped_before_);
        status.gaps = counters.gaps;
        status.journal = journal_->status();
        status.journal_failure = status.journal.failure;
        if (now >= status_at_ || !oldest_ns_) find_oldest(now);
        if (counters.waiting > 0) status.oldest_waiting_ns = oldest_ns_;
        work_->report(now, status);
        status.behind_per_s = pace_->note(now, status);
        if (status.behind_per_s > 0) status.state = OutputState::falls_behind;
    }
    output_log_->note(status);
    const std::lock_guard lock(status_mutex_);
    status_ = std::move(status);
    status_taken_ = taken_;
    status_lost_ = taken_lost_;
}

}  // namespace takt::publish
