#include "takt/publish/outputs.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <string>
#include <string_view>
#include <utility>

#include "takt/base/assert.hpp"
#include "takt/line/loop.hpp"
#include "takt/os/thread_name.hpp"

namespace takt::publish {

Outputs::Outputs(std::unique_ptr<host::Session> session, MakeSetups make_setups)
    : session_(std::move(session)),
      make_setups_(std::move(make_setups)),
      sampler_(*session_, *this, system_wall_ns, line::now()),
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
    ring();
    thread_.join();
}

// EAGAIN means that a wake-up is already pending.
void Outputs::ring() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(bell_.get(), &one, sizeof one);
}

std::vector<OutputStatus> Outputs::status() const {
    std::vector<std::shared_ptr<OutputThread>> threads;
    std::vector<OutputStatus> removed;
    {
        const std::lock_guard lock(threads_mutex_);
        if (!last_status_.empty()) return last_status_;
        threads = threads_;
        removed = removed_;
    }
    std::vector<OutputStatus> all;
    for (const auto& thread : threads) all.push_back(thread->status());
    all.insert(all.end(), removed.begin(), removed.end());
    return all;
}

void Outputs::run() {
    os::name_thread("takt-outputs");
    while (!stopping_) {
        sampler_.step(line::now());
        wait(sampler_.next_wakeup());
    }
    sampler_.finish(line::now());
    for (auto& running : running_) running.thread->ask_to_stop();
    for (auto& running : running_) running.thread->finish();
    std::vector<OutputStatus> last;
    for (const auto& running : running_) last.push_back(running.thread->status());
    const std::lock_guard lock(threads_mutex_);
    last.insert(last.end(), removed_.begin(), removed_.end());
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
    std::uint64_t rings = 0;
    [[maybe_unused]] const auto drained = ::read(bell_.get(), &rings, sizeof rings);
}

// Outputs that are not in the new project, or have other settings, end before their successors begin: they
// share a directory.
std::vector<SampleFeed*> Outputs::on_configuration(Instant now, const host::ConfigurationPtr& configuration) {
    auto setups = make_setups_(configuration);
    const auto series = series_of(*configuration);
    std::vector<std::shared_ptr<OutputThread>> continued(setups.size());
    for (std::size_t i = 0; i < setups.size(); ++i)
        for (auto& running : running_)
            if (running.thread->name() == setups[i].thread.name && running.settings == setups[i].settings)
                continued[i] = running.thread;
    for (auto& setup : setups)
        if (std::ranges::any_of(running_,
                                [&](const auto& its) { return its.directory == setup.thread.directory; }))
            setup.thread.journal.start = store::GapCause::replaced;
    end_others(continued, setups);

    std::vector<SampleFeed*> feeds;
    for (std::size_t i = 0; i < setups.size(); ++i) {
        auto& setup = setups[i];
        setup.thread.wake_sampler = [this] { ring(); };
        const auto log = setup.thread.log;
        auto directory = setup.thread.directory;
        auto thread = continued[i];
        if (!thread) thread = std::make_shared<OutputThread>(std::move(setup.thread), setup.make_work());
        auto feed = std::make_unique<SampleFeed>(series, setup.selected, thread->queue(), now);
        feeds.push_back(feed.get());
        running_.push_back(
            {std::move(setup.settings), std::move(directory), log, std::move(thread), std::move(feed)});
    }
    const std::lock_guard lock(threads_mutex_);
    for (const auto& running : running_) threads_.push_back(running.thread);
    return feeds;
}

void Outputs::end_others(const std::vector<std::shared_ptr<OutputThread>>& continued,
                         const std::vector<OutputSetup>& setups) {
    const auto is_in_project = [&](std::string_view name) {
        return std::ranges::any_of(setups, [&](const auto& setup) { return setup.thread.name == name; });
    };
    auto former = std::exchange(running_, {});
    {
        const std::lock_guard lock(threads_mutex_);
        threads_.clear();
        std::erase_if(removed_, [&](const auto& status) { return is_in_project(status.name); });
    }
    std::erase_if(former,
                  [&](const Running& running) { return std::ranges::count(continued, running.thread) > 0; });
    for (auto& running : former) running.thread->ask_to_stop();
    for (auto& running : former) running.thread->finish();
    for (const auto& running : former)
        if (!is_in_project(running.thread->name())) note_removed(running);
}

// The samples stay in the journal, which no output reads any more.
void Outputs::note_removed(const Running& ended) {
    auto status = ended.thread->status();
    if (status.samples.waiting == 0) return;
    const auto count = std::to_string(status.samples.waiting);
    const std::array arguments{LogArgument{.name = "name", .text = status.name},
                               LogArgument{.name = "count", .text = count},
                               LogArgument{.name = "directory", .text = ended.directory}};
    ended.log.message(LogLevel::warning, "log.output.removed", arguments);
    status.state = OutputState::removed;
    status.destination = ended.directory;
    status.failure.clear();
    const std::lock_guard lock(threads_mutex_);
    removed_.push_back(std::move(status));
}

void Outputs::on_enqueued(std::size_t feed) {
    running_[feed].thread->wake();
}

void Outputs::on_state_changed() {
    for (auto& running : running_) running.thread->state_changed();
}

}  // namespace takt::publish
