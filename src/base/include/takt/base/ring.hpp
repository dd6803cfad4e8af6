// A first-in first-out queue of bounded length, stored in place.
#pragma once

#include <array>
#include <cstddef>
#include <utility>

#include "takt/base/assert.hpp"

namespace takt {

/// At most N elements, first in, first out; never allocates. One owner, one thread.
template <class T, std::size_t N>
class Ring {
public:
    /// @returns false, changing nothing, when the ring is full.
    [[nodiscard]] bool try_push(T value) {
        if (size_ == N) return false;
        items_[(first_ + size_) % N] = std::move(value);
        ++size_;
        return true;
    }
    [[nodiscard]] const T& front() const {
        TAKT_ASSERT(size_ > 0);
        return items_[first_];
    }
    T pop() {
        TAKT_ASSERT(size_ > 0);
        T value = std::move(items_[first_]);
        first_ = (first_ + 1) % N;
        --size_;
        return value;
    }
    void clear() { first_ = size_ = 0; }

    [[nodiscard]] std::size_t size() const { return size_; }
    [[nodiscard]] bool empty() const { return size_ == 0; }
    [[nodiscard]] bool full() const { return size_ == N; }
    static constexpr std::size_t capacity() { return N; }

private:
    std::array<T, N> items_{};
    std::size_t first_ = 0;
    std::size_t size_ = 0;
};

}  // namespace takt
