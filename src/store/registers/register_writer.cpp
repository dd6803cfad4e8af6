// The owner's thread changes `wanted`; the worker commits `writing`. Before each commit the range that
// changed is copied from the one to the other under the mutex, so writes that arrive during a commit share
// the next one (group commit). A ticket numbers each change; a commit makes all tickets up to the last one
// that it copied durable.
#include "takt/store/register_writer.hpp"

#include <algorithm>
#include <chrono>
#include <mutex>
#include <utility>

#include "takt/base/assert.hpp"
#include "takt/os/worker.hpp"

namespace takt::store {
namespace {

constexpr Duration kRetry = std::chrono::seconds(1);
using Clock = os::Worker::Clock;

}  // namespace

struct RegisterWriter::Impl {
    Impl(std::unique_ptr<BlockFile> under, RegisterFile written, Options with)
        : storage(std::move(under)),
          file(std::move(written)),
          options(std::move(with)),
          wanted(file.image().begin(), file.image().end()),
          writing(wanted) {}

    std::unique_ptr<BlockFile> storage;
    RegisterFile file;  // the worker's; the owner's while the worker is stopped by a failure
    Options options;

    mutable std::mutex mutex;
    std::vector<std::uint8_t> wanted;  // the image with all changes
    std::size_t changed_from = 0;      // of `wanted`, against `writing`
    std::size_t changed_to = 0;
    std::uint64_t ticket = 0;  // of the last change
    Progress progress;
    RegisterFile::Counters counters;
    bool closing = false;

    bool scheduled = false;  // commit() is posted or runs
    Clock::time_point not_before = Clock::time_point::min();
    bool tried_last = false;  // the one commit of the end was tried

    std::vector<std::uint8_t> writing;          // the worker's
    os::Worker worker{{.name = "takt-store"}};  // last: it uses the other members

    void schedule();
    void commit();
    [[nodiscard]] bool has_work() const;
    void copy_changes();
    void note(const Result<void>& committed, std::uint64_t covered);
};

// Needs the mutex.
void RegisterWriter::Impl::schedule() {
    const bool pending = progress.durable < ticket && !progress.stopped;
    scheduled = pending && options.durability != Durability::at_end &&
                worker.post_at(not_before, [this] { commit(); });
}

bool RegisterWriter::Impl::has_work() const {
    if (progress.stopped || tried_last) return false;
    // A refused image may be what a restart finds: at the end the durable image is written over it.
    return progress.durable < ticket || (closing && progress.failed);
}

void RegisterWriter::Impl::copy_changes() {
    const auto from = static_cast<std::ptrdiff_t>(changed_from);
    const auto to = static_cast<std::ptrdiff_t>(changed_to);
    std::copy(wanted.begin() + from, wanted.begin() + to, writing.begin() + from);
    changed_from = changed_to = 0;
}

void RegisterWriter::Impl::note(const Result<void>& committed, std::uint64_t covered) {
    counters = file.counters();
    progress.failed = !committed;
    if (committed) {
        progress.durable = covered;
    } else {
        progress.why = committed.error();
        progress.stopped = options.durability == Durability::acknowledged;
    }
}

void RegisterWriter::Impl::commit() {
    std::unique_lock lock(mutex);
    scheduled = has_work();
    if (!scheduled) return;
    copy_changes();
    const std::uint64_t covered = ticket;
    tried_last = closing;
    lock.unlock();
    const auto committed = file.commit(writing);
    lock.lock();
    note(committed, covered);
    if (options.durability == Durability::interval)
        not_before = Clock::now() + (committed ? options.interval : std::max(options.interval, kRetry));
    lock.unlock();
    if (options.on_progress) options.on_progress();
    lock.lock();
    schedule();
}

RegisterWriter::RegisterWriter(std::unique_ptr<BlockFile> storage, RegisterFile file, Options options)
    : impl_(std::make_unique<Impl>(std::move(storage), std::move(file), std::move(options))) {}

RegisterWriter::~RegisterWriter() {
    close();
}

void RegisterWriter::close() {
    {
        const std::lock_guard lock(impl_->mutex);
        impl_->closing = true;
    }
    impl_->worker.post([this] { impl_->commit(); });
    impl_->worker.finish();
}

std::uint64_t RegisterWriter::change(std::span<const Change> changes) {
    Impl& writer = *impl_;
    const std::lock_guard lock(writer.mutex);
    bool differs = false;
    for (const auto& [offset, bytes] : changes) {
        TAKT_ASSERT(offset + bytes.size() <= writer.wanted.size());
        const auto at = writer.wanted.begin() + static_cast<std::ptrdiff_t>(offset);
        if (std::equal(bytes.begin(), bytes.end(), at)) continue;
        std::ranges::copy(bytes, at);
        const bool first = writer.changed_from == writer.changed_to;
        writer.changed_from = first ? offset : std::min(writer.changed_from, offset);
        writer.changed_to = std::max(writer.changed_to, offset + bytes.size());
        differs = true;
    }
    if (!differs) return writer.ticket;
    ++writer.ticket;
    if (!writer.scheduled) writer.schedule();
    return writer.ticket;
}

RegisterWriter::Progress RegisterWriter::progress() const {
    const std::lock_guard lock(impl_->mutex);
    return impl_->progress;
}

RegisterFile::Counters RegisterWriter::counters() const {
    const std::lock_guard lock(impl_->mutex);
    return impl_->counters;
}

// The worker does not touch the file while it is stopped.
void RegisterWriter::roll_back(std::vector<std::uint8_t>& image) {
    Impl& writer = *impl_;
    const std::lock_guard lock(writer.mutex);
    TAKT_ASSERT(writer.progress.stopped);
    const Bytes durable = writer.file.image();
    image.assign(durable.begin(), durable.end());
    writer.wanted = image;
    writer.writing = image;
    writer.changed_from = writer.changed_to = 0;
    writer.progress.durable = writer.ticket;
    writer.progress.stopped = false;
}

}  // namespace takt::store
