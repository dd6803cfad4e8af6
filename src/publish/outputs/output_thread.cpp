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
#include "takt/os/priority.hpp"
#include "takt/os/thread_name.hpp"
#include "takt/store/posix_journal_storage.hpp"

namespace takt::publish {
namespace {

Result<std::unique_ptr<store::JournalStorage>> open_directory(const std::string& directory,
                                                              std::size_t segment_bytes) {
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (error) return fail(Code::cannot_open, directory, error.value());
    return store::PosixJournalStorage::open(directory, segment_bytes);
}

OutputEngine::Options engine_options(OutputThread::Options options) {
    const auto segment_bytes = options.journal.segment_bytes;
    return {.name = std::move(options.name),
            .journal = options.journal,
            .queue_bytes = options.queue_bytes,
            .stop_limit = options.stop_limit,
            .open_storage = [directory = std::move(options.directory),
                             segment_bytes] { return open_directory(directory, segment_bytes); },
            .wake_sampler = std::move(options.wake_sampler),
            .log = options.log};
}

}  // namespace

OutputThread::OutputThread(Options options, std::unique_ptr<OutputWork> work)
    : bell_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      engine_(engine_options(std::move(options)), std::move(work)) {
    TAKT_ASSERT(bell_);
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

// While a backlog is delivered, polling must keep its times.
void OutputThread::run() {
    os::name_thread("takt-output");
    os::become_background_thread();
    for (;;) {
        const auto now = line::now();
        if (stopping_) engine_.stop();
        if (state_changed_.exchange(false)) engine_.on_state_changed(now);
        step(now);
        if (engine_.finished(now)) break;
        wait(engine_.next_wakeup());
    }
    const auto now = line::now();
    step_began_ = now.time_since_epoch().count();
    engine_.close(now);
    step_began_ = kWaiting;
}

void OutputThread::step(Instant now) {
    step_began_ = now.time_since_epoch().count();
    engine_.step(now);
    step_began_ = kWaiting;
}

// A step waits for the disk only, so a long one shows that the disk hangs. The status of the engine is that
// of the step before.
OutputStatus OutputThread::status() const {
    const Instant::rep began = step_began_;
    auto status = engine_.status();
    if (began == kWaiting) return status;
    const Duration waits = line::now() - Instant(Duration(began));
    if (waits >= kDiskHangs) status.disk_waits = waits;
    return status;
}

void OutputThread::wait(Instant until) {
    std::vector<pollfd> descriptors{{.fd = bell_.get(), .events = POLLIN, .revents = 0}};
    for (const int descriptor : engine_.descriptors())
        descriptors.push_back({.fd = descriptor, .events = POLLIN, .revents = 0});
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(
        std::clamp<Duration>(until == kNever ? std::chrono::minutes(1) : until - line::now(), Duration{},
                             std::chrono::minutes(1)));
    (void)::poll(descriptors.data(), descriptors.size(), static_cast<int>(left.count()));
    std::uint64_t rings = 0;
    [[maybe_unused]] const auto drained = ::read(bell_.get(), &rings, sizeof rings);
}

}  // namespace takt::publish
