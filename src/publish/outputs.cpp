#include "takt/publish/outputs.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <utility>
#include <variant>

#include "takt/base/assert.hpp"
#include "takt/line/loop.hpp"

namespace takt::publish {

Outputs::Outputs(std::unique_ptr<host::Session> session, MakeSetups make_setups)
    : session_(std::move(session)),
      make_setups_(std::move(make_setups)),
      last_event_(line::now()),
      bell_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    TAKT_ASSERT(bell_);
    thread_ = std::thread([this] { run(); });
}

Outputs::~Outputs() {
    stop();
}

void Outputs::stop() {
    const std::lock_guard lock(stop_mutex_);
    if (!thread_.joinable()) return;
    stopping_ = true;
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(bell_.get(), &one, sizeof one);
    thread_.join();
}

std::vector<OutputStatus> Outputs::status() const {
    std::vector<std::shared_ptr<OutputThread>> threads;
    {
        const std::lock_guard lock(threads_mutex_);
        if (!last_status_.empty()) return last_status_;
        threads = threads_;
    }
    std::vector<OutputStatus> all;
    for (const auto& thread : threads) all.push_back(thread->status());
    return all;
}

void Outputs::run() {
    while (!stopping_) {
        const auto now = line::now();
        set_clocks(now);
        follow_configuration(now);
        read_events(now);
        count_lost(now);
        if (std::exchange(current_due_, false)) deliver_current(now);
        sample_due(now);
        if (flush_at_ <= now) flush();
        wait(next_wakeup());
    }
    read_events(line::now());
    count_lost(line::now());
    flush();
    for (auto& running : running_) running.thread->ask_to_stop();
    for (auto& running : running_) running.thread->finish();
    std::vector<OutputStatus> last;
    for (const auto& running : running_) last.push_back(running.thread->status());
    const std::lock_guard lock(threads_mutex_);
    last_status_ = std::move(last);
}

void Outputs::wait(Instant until) {
    if (session_->rearm()) return;
    const auto most = std::chrono::milliseconds(60'000);
    const auto left =
        until == kNever ? Duration(most) : std::clamp<Duration>(until - line::now(), Duration{}, most);
    pollfd descriptors[] = {{.fd = session_->descriptor(), .events = POLLIN, .revents = 0},
                            {.fd = bell_.get(), .events = POLLIN, .revents = 0}};
    (void)::poll(descriptors, std::size(descriptors),
                 static_cast<int>(std::chrono::ceil<std::chrono::milliseconds>(left).count()));
}

Instant Outputs::next_wakeup() const {
    Instant next = flush_at_;
    for (const auto& running : running_) next = std::min(next, running.feed->next_due());
    return next;
}

void Outputs::set_clocks(Instant now) {
    const auto wall = line::wall_clock(now).time_since_epoch();
    const auto offset = std::chrono::duration_cast<std::chrono::nanoseconds>(wall) - now.time_since_epoch();
    for (auto& running : running_) running.feed->set_clock(offset.count());
}

// Outputs that are not in the new project, or have other settings, end before their successors begin: they
// share a directory.
void Outputs::follow_configuration(Instant now) {
    if (session_->configuration() == configuration_) return;
    flush();
    configuration_ = session_->configuration();
    auto setups = make_setups_(configuration_);
    const auto series = series_of(*configuration_);
    auto former = std::move(running_);
    std::vector<std::shared_ptr<OutputThread>> continued(setups.size());
    for (std::size_t i = 0; i < setups.size(); ++i)
        for (auto& running : former)
            if (running.thread->name() == setups[i].thread.name && running.settings == setups[i].settings)
                continued[i] = running.thread;
    {
        const std::lock_guard lock(threads_mutex_);
        threads_.clear();
    }
    std::erase_if(former,
                  [&](const Running& running) { return std::ranges::count(continued, running.thread) > 0; });
    for (auto& running : former) running.thread->ask_to_stop();
    for (auto& running : former) running.thread->finish();
    former.clear();

    for (std::size_t i = 0; i < setups.size(); ++i) {
        auto& setup = setups[i];
        auto thread = continued[i];
        if (!thread) thread = std::make_shared<OutputThread>(std::move(setup.thread), setup.make_work());
        auto feed = std::make_unique<SampleFeed>(series, setup.selected, thread->queue(), now);
        running_.push_back({std::move(setup.settings), std::move(thread), std::move(feed)});
    }
    {
        const std::lock_guard lock(threads_mutex_);
        for (const auto& running : running_) threads_.push_back(running.thread);
    }
    set_clocks(now);
    current_due_ = true;
}

void Outputs::read_events(Instant now) {
    while (const auto event = session_->next_event()) {
        if (session_->configuration() != configuration_) follow_configuration(now);
        last_event_ = event->t;
        on_event(*event);
    }
    const bool collected =
        std::ranges::any_of(running_, [](const Running& r) { return r.feed->collected(); });
    if (collected && flush_at_ == kNever) flush_at_ = now + kCollect;
}

void Outputs::on_event(const host::Event& event) {
    if (const auto* const changed = std::get_if<host::ValueChanged>(&event.body)) {
        for (auto& running : running_) running.feed->on_change(event.t, *changed);
    } else if (const auto* const lost = std::get_if<host::EventsLost>(&event.body)) {
        lost_ += lost->count;
    } else if (std::holds_alternative<host::DeviceStateChanged>(event.body) ||
               std::holds_alternative<host::LinkChanged>(event.body)) {
        for (auto& running : running_) running.thread->state_changed();
    }
}

// The values that the lost events had are known again from a snapshot.
void Outputs::count_lost(Instant now) {
    const auto missed = session_->missed_events();
    const auto lost = std::exchange(lost_, 0) + (missed - missed_);
    missed_ = missed;
    if (lost == 0) return;
    for (auto& running : running_) running.feed->lose(lost, last_event_, now);
    current_due_ = true;
}

// The events up to the moment of the snapshot are read before it is used, so the samples of a slot stay in
// order.
std::optional<host::Snapshot> Outputs::take_snapshot(Instant now) {
    auto snapshot = session_->snapshot({});
    read_events(now);
    if (!snapshot || snapshot->configuration != configuration_) return std::nullopt;
    return *std::move(snapshot);
}

void Outputs::sample_due(Instant now) {
    const bool due =
        std::ranges::any_of(running_, [&](const Running& r) { return r.feed->next_due() <= now; });
    if (!due) return;
    const auto snapshot = take_snapshot(now);
    if (!snapshot) return;
    for (auto& running : running_) running.feed->on_snapshot(snapshot->t, snapshot->values);
    flush();
}

void Outputs::deliver_current(Instant now) {
    const auto snapshot = take_snapshot(now);
    if (!snapshot) return;
    for (auto& running : running_) running.feed->deliver_current(snapshot->t, snapshot->values);
    flush();
}

void Outputs::flush() {
    flush_at_ = kNever;
    for (auto& running : running_)
        if (running.feed->flush()) running.thread->wake();
}

}  // namespace takt::publish
