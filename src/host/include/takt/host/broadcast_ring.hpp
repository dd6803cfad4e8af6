// A bounded ring of records with one writer and any number of independent readers.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace takt::host {

/// Records of 64-bit words. The writer never waits: it overwrites the oldest records. A reader that is too
/// slow continues with the oldest record that is left and learns how many it missed.
///
/// Threads: append() on one thread; begin(), end() and read() on any thread, each with a cursor of its own.
/// Nothing allocates but the constructor and the growth of the reader's buffer, and nothing takes a lock.
class BroadcastRing {
public:
    /// A reader's position.
    struct Cursor {
        std::uint64_t position = 0;  ///< in words since the ring was made
        std::uint64_t next = 0;      ///< number of the next record, from 0
        std::uint64_t missed = 0;    ///< records that were overwritten before they were read
    };

    /// @param words  capacity, a power of two; a record takes two words more than its content
    explicit BroadcastRing(std::size_t words);

    /// Longest record that append() takes, in words: about a quarter of the capacity.
    [[nodiscard]] std::size_t longest() const { return (mask_ + 1) / 4 - 2 * kHeader; }

    /// @param record  1 to longest() words
    void append(std::span<const std::uint64_t> record);

    /// The oldest record that is left, and the one that will be appended next.
    [[nodiscard]] Cursor begin() const { return cursor_at(tail_); }
    [[nodiscard]] Cursor end() const { return cursor_at(head_); }

    /// Copies the next record and moves the cursor behind it. @returns false when there is none
    [[nodiscard]] bool read(Cursor& cursor, std::vector<std::uint64_t>& record) const;

    /// Whether read() would find a record.
    [[nodiscard]] bool has_more(const Cursor& cursor) const {
        return cursor.position != head_.load(std::memory_order_acquire);
    }

private:
    static constexpr std::size_t kHeader = 2;  // number of words in the content, number of the record

    [[nodiscard]] Cursor cursor_at(const std::atomic<std::uint64_t>& end) const;
    [[nodiscard]] std::atomic<std::uint64_t>& word(std::uint64_t position) const {
        return words_[position & mask_];
    }

    std::size_t mask_;
    std::unique_ptr<std::atomic<std::uint64_t>[]> words_;
    std::atomic<std::uint64_t> head_ = 0;  // behind the last complete record
    std::atomic<std::uint64_t> tail_ = 0;  // the oldest record that is not being overwritten
    std::uint64_t appended_ = 0;           // the writer's
};

}  // namespace takt::host
