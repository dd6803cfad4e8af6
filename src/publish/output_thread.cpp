#include "takt/publish/output_thread.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "takt/base/assert.hpp"
#include "takt/line/loop.hpp"

namespace takt::publish {
namespace {

constexpr store::DestinationId kDestination{0};

std::int64_t wall_ns(Instant t) {
    const auto since = line::wall_clock(t).time_since_epoch();
    return std::chrono::duration_cast<std::chrono::nanoseconds>(since).count();
}

Result<void> make_directory(const std::string& directory) {
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (error) return fail(Code::cannot_open, directory, error.value());
    return {};
}

}  // namespace

OutputThread::OutputThread(Options options, std::unique_ptr<OutputWork> work)
    : options_(std::move(options)),
      queue_(options_.queue_bytes),
      bell_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      work_(std::move(work)) {
    TAKT_ASSERT(bell_);
    status_.name = options_.name;
    thread_ = std::thread([this] { run(); });
}

OutputThread::~OutputThread() {
    finish();
}

void OutputThread::finish() {
    ask_to_stop();
    if (thread_.joinable()) thread_.join();
}

void OutputThread::wake() {
    const std::uint64_t one = 1;
    // EAGAIN means that a wake-up is already pending.
    [[maybe_unused]] const auto written = ::write(bell_.get(), &one, sizeof one);
}

void OutputThread::state_changed() {
    state_changed_ = true;
    wake();
}

void OutputThread::ask_to_stop() {
    stopping_ = true;
    wake();
}

OutputStatus OutputThread::status() const {
    const std::lock_guard lock(status_mutex_);
    auto status = status_;
    const auto queued = queue_.pushed() - status_taken_;
    status.samples.sampled += queued;
    status.samples.waiting += queued;
    return status;
}

void OutputThread::run() {
    for (;;) {
        const auto now = line::now();
        if (!journal_) try_to_open(now);
        if (journal_) work(now);
        if (stopping_) stop(now);
        publish_status(now);
        if (stopping_ && (!journal_ || (leaving_ && work_->stopped()) || now >= stop_until_)) break;
        wait(std::min(next_wakeup(), stop_until_));
    }
    if (journal_) {
        take_queue(line::now());
        if (const auto closed = journal_->close(line::now()); !closed)
            options_.log(LogLevel::error, "journal not closed", options_.name);
    }
    publish_status(line::now());
    const std::lock_guard lock(status_mutex_);
    status_.state = OutputState::ended;
}

// What a destination takes at the moment, it gets to the last sample. The rest waits for the next start.
void OutputThread::stop(Instant now) {
    if (stop_until_ == kNever) {
        stop_until_ = now + options_.stop_limit;
        if (!journal_) return;
        take_queue(now);
        // An error is in the status of the journal, and it is tried again at the end.
        static_cast<void>(journal_->close(now));
        work_->work(now);
    }
    if (!journal_ || leaving_) return;
    const bool more = work_->takes_records() && journal_->counters(kDestination).waiting > 0;
    if (more && now < stop_until_ - options_.stop_limit / 2) return;
    leaving_ = true;
    work_->stop(now);
    work_->work(now);
}

void OutputThread::wait(Instant until) {
    std::vector<pollfd> descriptors{{.fd = bell_.get(), .events = POLLIN, .revents = 0}};
    if (journal_)
        for (const int descriptor : work_->descriptors())
            descriptors.push_back({.fd = descriptor, .events = POLLIN, .revents = 0});
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(
        std::clamp<Duration>(until == kNever ? std::chrono::minutes(1) : until - line::now(), Duration{},
                             std::chrono::minutes(1)));
    (void)::poll(descriptors.data(), descriptors.size(), static_cast<int>(left.count()));
    std::uint64_t rings = 0;
    [[maybe_unused]] const auto drained = ::read(bell_.get(), &rings, sizeof rings);
}

void OutputThread::try_to_open(Instant now) {
    if (now < open_again_) return;
    open_again_ = now + kOpenAgain;
    const auto open = [&]() -> Result<store::Journal> {
        TAKT_CHECK(make_directory(options_.directory));
        if (!storage_) {
            TAKT_TRY(storage_,
                     store::PosixJournalStorage::open(options_.directory, options_.journal.segment_bytes));
        }
        const std::string_view destinations[] = {options_.name};
        return store::Journal::open(*storage_, options_.journal, destinations, now, wall_ns(now));
    };
    auto opened = open();
    if (!opened) {
        if (open_failure_ != opened.error())
            options_.log(LogLevel::error, "journal not opened", options_.name);
        open_failure_ = opened.error();
        return;
    }
    open_failure_.reset();
    journal_.emplace(*std::move(opened));
    appended_before_ = journal_->counters(kDestination).appended;
    work_->begin(now, *journal_, kDestination);
}

void OutputThread::take_queue(Instant now) {
    while (const auto queued = queue_.take()) {
        taken_ += queued->samples;
        if (queued->payload.empty())
            journal_->append_loss(now, queued->samples, queued->first_wall_ns, queued->last_wall_ns);
        else
            // A full buffer is counted by the journal, and a payload has a size that it takes.
            static_cast<void>(journal_->append(now, {.samples = queued->samples,
                                                     .wall_ns = queued->last_wall_ns,
                                                     .monotonic_ns = queued->last_monotonic_ns,
                                                     .payload = queued->payload}));
    }
}

void OutputThread::work(Instant now) {
    take_queue(now);
    if (journal_->next_wakeup() <= now) journal_->on_tick(now, wall_ns(now));
    if (state_changed_.exchange(false)) work_->on_state_changed(now);
    work_->work(now);
}

Instant OutputThread::next_wakeup() const {
    if (!journal_) return open_again_;
    return std::min(journal_->next_wakeup(), work_->next_wakeup());
}

// A start that lost nothing is a gap without samples.
void OutputThread::find_oldest(Instant now) {
    status_at_ = now + std::chrono::seconds(1);
    oldest_ns_.reset();
    if (journal_->counters(kDestination).waiting == 0) return;
    const auto stream = journal_->replay(journal_->acknowledged(kDestination) + 1);
    for (auto entry = stream->next(); entry && *entry && !oldest_ns_; entry = stream->next())
        if ((*entry)->header.samples > 0) oldest_ns_ = (*entry)->header.wall_ns;
}

void OutputThread::publish_status(Instant now) {
    OutputStatus status;
    status.name = options_.name;
    status.journal_failure = open_failure_;
    status.samples.sampled = appended_before_ + taken_;
    if (journal_) {
        const auto counters = journal_->counters(kDestination);
        status.samples.delivered = counters.delivered;
        status.samples.dropped = counters.dropped;
        status.samples.waiting = counters.waiting;
        status.journal = journal_->status();
        status.journal_failure = status.journal.failure;
        if (now >= status_at_ || !oldest_ns_) find_oldest(now);
        if (counters.waiting > 0) status.oldest_waiting_ns = oldest_ns_;
        work_->report(now, status);
    }
    const std::lock_guard lock(status_mutex_);
    status_ = std::move(status);
    status_taken_ = taken_;
}

}  // namespace takt::publish
