// A priority queue whose elements can change their key and be removed: a binary heap with an index from each
// element to its position.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "takt/base/assert.hpp"

namespace takt::poll {

/// A set of numbers of 0..n-1, the one with the least key first. put() and remove() are O(log n). Allocates
/// in the constructor only. Key: ordered by `<`.
template <class Key>
class IndexedHeap {
public:
    explicit IndexedHeap(std::size_t n) : keys_(n), places_(n, kNowhere) { heap_.reserve(n); }

    [[nodiscard]] bool empty() const { return heap_.empty(); }
    [[nodiscard]] std::uint32_t top() const {
        TAKT_ASSERT(!heap_.empty());
        return heap_.front();
    }
    [[nodiscard]] const Key& top_key() const { return keys_[top()]; }
    /// All elements, in no particular order.
    [[nodiscard]] std::span<const std::uint32_t> all() const { return heap_; }

    /// Inserts it, or changes its key.
    void put(std::uint32_t index, const Key& key) {
        if (places_[index] == kNowhere) {
            places_[index] = static_cast<std::uint32_t>(heap_.size());
            heap_.push_back(index);
        }
        keys_[index] = key;
        sift_down(sift_up(places_[index]));
    }

    /// Removes it, if it is an element.
    void remove(std::uint32_t index) {
        const std::uint32_t place = places_[index];
        if (place == kNowhere) return;
        const std::uint32_t last = heap_.back();
        heap_.pop_back();
        places_[index] = kNowhere;
        if (last == index) return;
        heap_[place] = last;
        places_[last] = place;
        sift_down(sift_up(place));
    }

private:
    static constexpr std::uint32_t kNowhere = UINT32_MAX;

    [[nodiscard]] bool before(std::size_t a, std::size_t b) const {
        return keys_[heap_[a]] < keys_[heap_[b]];
    }

    void swap(std::size_t a, std::size_t b) {
        std::swap(heap_[a], heap_[b]);
        places_[heap_[a]] = static_cast<std::uint32_t>(a);
        places_[heap_[b]] = static_cast<std::uint32_t>(b);
    }

    std::size_t sift_up(std::size_t place) {
        while (place > 0 && before(place, (place - 1) / 2)) {
            swap(place, (place - 1) / 2);
            place = (place - 1) / 2;
        }
        return place;
    }

    void sift_down(std::size_t place) {
        for (;;) {
            std::size_t least = place;
            for (const std::size_t child : {2 * place + 1, 2 * place + 2})
                if (child < heap_.size() && before(child, least)) least = child;
            if (least == place) return;
            swap(place, least);
            place = least;
        }
    }

    std::vector<Key> keys_;              // by number
    std::vector<std::uint32_t> places_;  // by number: its place in heap_
    std::vector<std::uint32_t> heap_;
};

}  // namespace takt::poll
