// A priority queue whose elements can change their key and be removed: a binary heap with an index from each
// element to its position.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "takt/base/assert.hpp"

namespace takt::poll {

/// A set of numbers of 0..n-1, the one with the least key first. put() and remove() are O(log n). Allocates
/// in the constructor only. Key: ordered by `<`.
template <class Key>
class IndexedHeap {
public:
    explicit IndexedHeap(std::size_t n) : keys_(n), positions_(n, kNowhere) { heap_.reserve(n); }

    [[nodiscard]] bool empty() const { return heap_.empty(); }
    [[nodiscard]] std::uint32_t top() const {
        TAKT_ASSERT(!heap_.empty());
        return heap_.front();
    }
    [[nodiscard]] const Key& top_key() const { return keys_[top()]; }
    /// Calls visit(element) in the order of the keys until it returns false: O(k log k) for k calls.
    /// @param frontier  scratch: positions that are next, the least on top of a heap
    template <class Visit>
    void visit_in_order(std::vector<std::uint32_t>& frontier, const Visit& visit) const {
        const auto after = [this](std::uint32_t a, std::uint32_t b) { return before(b, a); };
        frontier.clear();
        if (!heap_.empty()) frontier.push_back(0);
        while (!frontier.empty()) {
            std::ranges::pop_heap(frontier, after);
            const std::uint32_t position = frontier.back();
            frontier.pop_back();
            if (!visit(heap_[position])) return;
            for (const std::uint32_t child : {2 * position + 1, 2 * position + 2}) {
                if (child >= heap_.size()) continue;
                frontier.push_back(child);
                std::ranges::push_heap(frontier, after);
            }
        }
    }

    /// Inserts it, or changes its key.
    void put(std::uint32_t index, const Key& key) {
        if (positions_[index] == kNowhere) {
            positions_[index] = static_cast<std::uint32_t>(heap_.size());
            heap_.push_back(index);
        }
        keys_[index] = key;
        sift_down(sift_up(positions_[index]));
    }

    /// Removes it, if it is an element.
    void remove(std::uint32_t index) {
        const std::uint32_t position = positions_[index];
        if (position == kNowhere) return;
        const std::uint32_t last = heap_.back();
        heap_.pop_back();
        positions_[index] = kNowhere;
        if (last == index) return;
        heap_[position] = last;
        positions_[last] = position;
        sift_down(sift_up(position));
    }

private:
    static constexpr std::uint32_t kNowhere = UINT32_MAX;

    [[nodiscard]] bool before(std::size_t a, std::size_t b) const {
        return keys_[heap_[a]] < keys_[heap_[b]];
    }

    void swap(std::size_t a, std::size_t b) {
        std::swap(heap_[a], heap_[b]);
        positions_[heap_[a]] = static_cast<std::uint32_t>(a);
        positions_[heap_[b]] = static_cast<std::uint32_t>(b);
    }

    std::size_t sift_up(std::size_t position) {
        while (position > 0 && before(position, (position - 1) / 2)) {
            swap(position, (position - 1) / 2);
            position = (position - 1) / 2;
        }
        return position;
    }

    void sift_down(std::size_t position) {
        for (;;) {
            std::size_t least = position;
            for (const std::size_t child : {2 * position + 1, 2 * position + 2})
                if (child < heap_.size() && before(child, least)) least = child;
            if (least == position) return;
            swap(position, least);
            position = least;
        }
    }

    std::vector<Key> keys_;                 // by number
    std::vector<std::uint32_t> positions_;  // by number: its position in heap_
    std::vector<std::uint32_t> heap_;
};

}  // namespace takt::poll
