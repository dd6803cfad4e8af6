// A sequence lock over a ring (H.-J. Boehm, "Can seqlocks get along with programming language memory
// models?", 2012). Invariant: every word in [tail_, head_) belongs to a complete record. The writer moves
// tail_ before it overwrites; a reader checks tail_ after it copied. Words are stored with release and loaded
// with acquire order, so a reader that saw an overwritten word also sees the tail_ that was stored before it.
// The number of the record that comes next is stored behind the last one before head_ moves, so that an empty
// ring has a cursor too.
#include "takt/host/broadcast_ring.hpp"

#include "takt/base/assert.hpp"

namespace takt::host {

BroadcastRing::BroadcastRing(std::size_t words)
    : mask_(words - 1), words_(std::make_unique<std::atomic<std::uint64_t>[]>(words)) {
    TAKT_ASSERT(words >= 32 && (words & mask_) == 0);
}

void BroadcastRing::append(std::span<const std::uint64_t> record) {
    TAKT_ASSERT(!record.empty() && record.size() <= longest());
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    const std::uint64_t end = head + kHeader + record.size();
    std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    while (end + kHeader - tail > mask_ + 1) tail += kHeader + word(tail).load(std::memory_order_relaxed);
    tail_.store(tail, std::memory_order_release);
    word(head).store(record.size(), std::memory_order_release);
    for (std::size_t i = 0; i < record.size(); ++i)
        word(head + kHeader + i).store(record[i], std::memory_order_release);
    word(end + 1).store(++appended_, std::memory_order_release);
    head_.store(end, std::memory_order_release);
}

BroadcastRing::Cursor BroadcastRing::cursor_at(const std::atomic<std::uint64_t>& end) const {
    for (;;) {
        const std::uint64_t position = end.load(std::memory_order_acquire);
        const std::uint64_t number = word(position + 1).load(std::memory_order_acquire);
        if (tail_.load(std::memory_order_acquire) <= position) return {.position = position, .next = number};
    }
}

bool BroadcastRing::read(Cursor& cursor, std::vector<std::uint64_t>& record) const {
    for (;;) {
        if (!has_more(cursor)) return false;
        const std::uint64_t oldest = tail_.load(std::memory_order_acquire);
        const std::uint64_t position = cursor.position < oldest ? oldest : cursor.position;
        const std::uint64_t size = word(position).load(std::memory_order_acquire);
        const std::uint64_t number = word(position + 1).load(std::memory_order_acquire);
        if (size <= longest()) {
            record.resize(size);
            for (std::size_t i = 0; i < size; ++i)
                record[i] = word(position + kHeader + i).load(std::memory_order_acquire);
        }
        if (tail_.load(std::memory_order_acquire) > position) continue;  // overwritten meanwhile
        cursor.missed += number - cursor.next;
        cursor.next = number + 1;
        cursor.position = position + kHeader + size;
        return true;
    }
}

}  // namespace takt::host
