#include "takt/store/register_keeper.hpp"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "takt/base/assert.hpp"

namespace takt::store {
namespace {

constexpr Duration kRetry = std::chrono::seconds(1);
using Clock = std::chrono::steady_clock;

}  // namespace

struct RegisterKeeper::Impl {
    Impl(std::unique_ptr<BlockFile> under, RegisterFile written, Options with)
        : storage(std::move(under)),
          file(std::move(written)),
          options(std::move(with)),
          wanted(file.image().begin(), file.image().end()),
          writing(wanted) {}

    std::unique_ptr<BlockFile> storage;
    RegisterFile file;  // the writing thread's; others while it waits in `stopped`
    Options options;

    mutable std::mutex mutex;
    std::condition_variable wake;
    std::vector<std::uint8_t> wanted;  // the image with all changes
    std::size_t changed_from = 0;      // of `wanted`, against `writing`
    std::size_t changed_to = 0;
    std::uint64_t ticket = 0;  // of the last change
    Progress progress;
    RegisterFile::Counters counters;
    bool closing = false;

    std::vector<std::uint8_t> writing;  // the writing thread's
    std::thread thread;

    void work();
    bool wait(std::unique_lock<std::mutex>& lock, Clock::time_point not_before);
    void copy_changes();
};

// False: there is nothing left to do.
bool RegisterKeeper::Impl::wait(std::unique_lock<std::mutex>& lock, Clock::time_point not_before) {
    const auto pending = [this] { return progress.durable < ticket; };
    wake.wait(lock, [&] {
        if (closing) return true;
        return !progress.stopped && pending() && options.durability != Durability::at_end;
    });
    if (!closing) wake.wait_until(lock, not_before, [&] { return closing; });
    // What was refused may be what a restart finds: at the end the durable image is written over it.
    return !progress.stopped && (pending() || (closing && progress.failed));
}

void RegisterKeeper::Impl::copy_changes() {
    const auto from = static_cast<std::ptrdiff_t>(changed_from);
    const auto to = static_cast<std::ptrdiff_t>(changed_to);
    std::copy(wanted.begin() + from, wanted.begin() + to, writing.begin() + from);
    changed_from = changed_to = 0;
}

void RegisterKeeper::Impl::work() {
    std::unique_lock lock(mutex);
    auto not_before = Clock::time_point::min();
    while (wait(lock, not_before)) {
        copy_changes();
        const std::uint64_t covered = ticket;
        const bool last = closing;
        lock.unlock();
        const auto committed = file.commit(writing);
        const auto pause = committed ? options.interval : std::max(options.interval, kRetry);
        if (options.durability == Durability::interval) not_before = Clock::now() + pause;
        lock.lock();
        counters = file.counters();
        progress.failed = !committed;
        if (committed) {
            progress.durable = covered;
        } else {
            progress.why = committed.error();
            progress.stopped = options.durability == Durability::acknowledged;
        }
        lock.unlock();
        if (options.on_progress) options.on_progress();
        lock.lock();
        if (last && !committed) break;
    }
}

RegisterKeeper::RegisterKeeper(std::unique_ptr<BlockFile> storage, RegisterFile file, Options options)
    : impl_(std::make_unique<Impl>(std::move(storage), std::move(file), std::move(options))) {
    impl_->thread = std::thread([this] { impl_->work(); });
}

RegisterKeeper::~RegisterKeeper() {
    close();
}

void RegisterKeeper::close() {
    {
        const std::lock_guard lock(impl_->mutex);
        impl_->closing = true;
    }
    impl_->wake.notify_all();
    if (impl_->thread.joinable()) impl_->thread.join();
}

std::uint64_t RegisterKeeper::change(std::span<const Change> changes) {
    Impl& keeper = *impl_;
    const std::lock_guard lock(keeper.mutex);
    bool differs = false;
    for (const auto& [offset, bytes] : changes) {
        TAKT_ASSERT(offset + bytes.size() <= keeper.wanted.size());
        const auto at = keeper.wanted.begin() + static_cast<std::ptrdiff_t>(offset);
        if (std::equal(bytes.begin(), bytes.end(), at)) continue;
        std::ranges::copy(bytes, at);
        const bool first = keeper.changed_from == keeper.changed_to;
        keeper.changed_from = first ? offset : std::min(keeper.changed_from, offset);
        keeper.changed_to = std::max(keeper.changed_to, offset + bytes.size());
        differs = true;
    }
    if (!differs) return keeper.ticket;
    ++keeper.ticket;
    keeper.wake.notify_all();
    return keeper.ticket;
}

RegisterKeeper::Progress RegisterKeeper::progress() const {
    const std::lock_guard lock(impl_->mutex);
    return impl_->progress;
}

RegisterFile::Counters RegisterKeeper::counters() const {
    const std::lock_guard lock(impl_->mutex);
    return impl_->counters;
}

// The thread does not touch the file while it is stopped.
void RegisterKeeper::roll_back(std::vector<std::uint8_t>& image) {
    Impl& keeper = *impl_;
    const std::lock_guard lock(keeper.mutex);
    TAKT_ASSERT(keeper.progress.stopped);
    const Bytes durable = keeper.file.image();
    image.assign(durable.begin(), durable.end());
    keeper.wanted = image;
    keeper.writing = image;
    keeper.changed_from = keeper.changed_to = 0;
    keeper.progress.durable = keeper.ticket;
    keeper.progress.stopped = false;
    keeper.wake.notify_all();
}

}  // namespace takt::store
