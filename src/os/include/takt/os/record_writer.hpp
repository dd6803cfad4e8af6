// Lines that are written by a thread of their own: a slow disk or reader never holds up the caller.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "takt/os/sink.hpp"
#include "takt/os/worker.hpp"

namespace takt::os {

/// Options of a RecordWriter.
struct WriterOptions {
    std::size_t limit = 4 << 20;  ///< bytes of records that wait, at most
    /// Makes the line that reports dropped records. Empty: they are not reported.
    std::function<std::string(std::uint64_t dropped)> gap_line;
    /// Least distance of two such lines.
    std::chrono::milliseconds gap_interval{0};
    /// Reports a write that failed: the first one, or the first one after records were written. Called by the
    /// writing thread with the system's error number. It must not call the writer.
    std::function<void(int error)> on_failure;
};

/// A bounded queue of records before a Sink, emptied by a thread of its own.
///
/// put() never blocks. A record that does not fit is dropped and counted. The count is reported by a line in
/// the stream, where records were dropped; with a `gap_interval` it may come later and cover several
/// drops. Records lost by a failed write are counted and reported likewise.
///
/// A record is formatted by the writing thread into one or more whole lines. put(), put_last(), drop(),
/// full(), closed(), error() and failures() are for any thread, finish() for the owner's.
template <class Record>
class RecordWriter {
public:
    /// Appends the lines of a record to `text`. Called by the writing thread.
    using Format = void (*)(const Record& record, std::string& text);

    RecordWriter(std::unique_ptr<Sink> sink, WriterOptions options, Format format)
        : sink_(std::move(sink)), options_(std::move(options)), format_(format) {}
    ~RecordWriter() { finish(); }
    RecordWriter(const RecordWriter&) = delete;
    RecordWriter& operator=(const RecordWriter&) = delete;

    /// Enqueues a record, or drops it when the queue is full. Does nothing after the end.
    void put(Record record) { enqueue(std::move(record), false); }

    /// Enqueues a record of any size, also into a full queue: a summary at the end.
    void put_last(Record record) { enqueue(std::move(record), true); }

    /// Counts a record that the caller dropped itself, for example because of a rate limit.
    void drop() {
        const std::lock_guard lock(mutex_);
        if (closed_ || ending_) return;
        ++dropped_;
        schedule();
    }

    /// Whether put() would drop that many bytes more.
    [[nodiscard]] bool full(std::size_t bytes) const {
        const std::lock_guard lock(mutex_);
        return queued_bytes_ + bytes > options_.limit;
    }

    /// Writes what is queued and ends; put() does nothing afterwards. Gives up when nothing could be written
    /// for `stall_timeout`. A second call does nothing.
    void finish(std::chrono::milliseconds stall_timeout = std::chrono::milliseconds(500)) {
        {
            const std::lock_guard lock(mutex_);
            if (std::exchange(ending_, true)) return;
        }
        sink_->finish_within(stall_timeout);
        worker_.finish();
        const std::lock_guard lock(mutex_);
        closed_ = true;
    }

    /// Nothing is written any more: finish() was called, the reader is gone or a write failed for good.
    [[nodiscard]] bool closed() const {
        const std::lock_guard lock(mutex_);
        return closed_ || sink_->reader_closed();
    }

    /// The system's error number if the last write failed, or any write after finish(): EPIPE, ENOSPC; else
    /// 0.
    [[nodiscard]] int error() const {
        const std::lock_guard lock(mutex_);
        return error_;
    }

    /// How many writes failed.
    [[nodiscard]] std::uint64_t failures() const {
        const std::lock_guard lock(mutex_);
        return failures_;
    }

private:
    using Clock = Worker::Clock;

    struct Entry {
        std::uint64_t dropped_before = 0;  // to be reported before the record
        Record record;
    };

    static constexpr std::size_t kChunk = 64 << 10;  // bytes of text for one write
    static constexpr auto kRetryDelay = std::chrono::seconds(1);

    static std::size_t size_of(const Record& record) {
        if constexpr (std::is_same_v<Record, std::string>)
            return record.size();
        else
            return sizeof(Record);
    }

    void enqueue(Record record, bool always) {
        const std::lock_guard lock(mutex_);
        if (closed_ || ending_) return;
        const std::size_t size = size_of(record);
        if (!always && queued_bytes_ + size > options_.limit) {
            ++dropped_;
        } else {
            queued_bytes_ += size;
            entries_.push_back({take_dropped(), std::move(record)});
        }
        schedule();
    }

    // The dropped records to report now; 0: none, or it is too early. Needs the mutex.
    std::uint64_t take_dropped() {
        if (dropped_ == 0) return 0;
        const auto now = Clock::now();
        if (!ending_ && now < next_gap_) return 0;
        next_gap_ = now + options_.gap_interval;
        return std::exchange(dropped_, 0);
    }

    // Needs the mutex.
    void schedule() {
        if (!scheduled_) scheduled_ = worker_.post([this] { write_queue(); });
    }

    // The writing thread. Returns when nothing is left to do now.
    void write_queue() {
        std::unique_lock lock(mutex_);
        while (!closed_) {
            batch_.swap(entries_);
            const std::uint64_t dropped = batch_.empty() ? take_dropped() : 0;
            if (batch_.empty() && dropped == 0) break;
            lock.unlock();
            write_batch();
            write_gap(dropped);
            lock.lock();
        }
        scheduled_ = false;
        if (closed_) {
            entries_.clear();
            queued_bytes_ = 0;
        }
        if (dropped_ > 0 && !closed_ && !report_scheduled_)
            report_scheduled_ = worker_.post_at(next_gap_, [this] { report_gap(); });
    }

    void report_gap() {
        {
            const std::lock_guard lock(mutex_);
            report_scheduled_ = false;
        }
        write_queue();
    }

    void write_batch() {
        std::size_t size = 0;
        for (const Entry& entry : batch_) {
            if (entry.dropped_before > 0) {
                write_text(std::exchange(size, 0));
                write_gap(entry.dropped_before);
            }
            format_(entry.record, text_);
            size += size_of(entry.record);
            if (text_.size() >= kChunk) write_text(std::exchange(size, 0));
        }
        write_text(size);
        batch_.clear();
    }

    // Writes the formatted text of records of that size.
    void write_text(std::size_t size) {
        if (!text_.empty()) write(text_, 0);
        text_.clear();
        const std::lock_guard lock(mutex_);
        queued_bytes_ -= size;
    }

    void write_gap(std::uint64_t dropped) {
        if (dropped > 0 && options_.gap_line) write(options_.gap_line(dropped), dropped);
    }

    // `reported`: the drops that the text reports; 0: it is of records.
    void write(const std::string& text, std::uint64_t reported) {
        {
            const std::lock_guard lock(mutex_);
            if (closed_) return;
        }
        const Sink::Written written = sink_->write(text);
        report(written.error, reported > 0);
        const std::lock_guard lock(mutex_);
        closed_ = closed_ || written.closed;
        // At the end a record that is lost stays an error, also when the shorter report of it fits.
        if (written.error != 0 || !lost_at_end_) error_ = written.error;
        if (written.error == 0) return;
        lost_at_end_ = ending_;
        ++failures_;
        next_gap_ = std::max(next_gap_, Clock::now() + kRetryDelay);
        const auto end_of_written = text.begin() + static_cast<std::ptrdiff_t>(written.bytes);
        if (reported == 0)
            dropped_ += static_cast<std::uint64_t>(std::count(end_of_written, text.end(), '\n'));
        else if (!ending_)  // at the end the report is tried once
            dropped_ += reported;
    }

    // A short report of drops may fit where no record does: it does not end a failure.
    void report(int error, bool of_drops) {
        if (error == 0 && of_drops) return;
        const bool begins = error != 0 && !failing_;
        failing_ = error != 0;
        if (begins && options_.on_failure) options_.on_failure(error);
    }

    const std::unique_ptr<Sink> sink_;
    const WriterOptions options_;
    const Format format_;

    mutable std::mutex mutex_;
    std::vector<Entry> entries_;
    std::size_t queued_bytes_ = 0;  // of records that are not written yet, also of those in batch_
    std::uint64_t dropped_ = 0;
    Clock::time_point next_gap_{};
    bool scheduled_ = false;         // write_queue() is posted or runs
    bool report_scheduled_ = false;  // report_gap() is posted
    bool ending_ = false;
    bool closed_ = false;
    bool lost_at_end_ = false;
    int error_ = 0;
    std::uint64_t failures_ = 0;

    std::vector<Entry> batch_;  // the writing thread's, as text_
    std::string text_;
    bool failing_ = false;

    Worker worker_;  // last: its thread uses the other members
};

/// A RecordWriter for lines that the caller has formatted.
class LineWriter : public RecordWriter<std::string> {
public:
    /// @param sink  lines go there, each with its line end
    explicit LineWriter(std::unique_ptr<Sink> sink, WriterOptions options = {})
        : RecordWriter(std::move(sink), std::move(options),
                       [](const std::string& line, std::string& text) { text += line; }) {}
    /// Writes to a descriptor, which is not closed.
    explicit LineWriter(int descriptor, WriterOptions options = {})
        : LineWriter(std::make_unique<DescriptorSink>(descriptor), std::move(options)) {}
};

}  // namespace takt::os
