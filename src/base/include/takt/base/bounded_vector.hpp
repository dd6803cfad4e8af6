// A sequence of bounded length in storage of the caller.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "takt/base/assert.hpp"

namespace takt {

/// Elements of a trivially copyable type, at most as many as the storage holds; never allocates. Like
/// InplaceVector, for capacities that are known only at run time. The storage must outlive it.
template <class T>
class BoundedVector {
public:
    constexpr BoundedVector() = default;
    constexpr explicit BoundedVector(std::span<T> storage) : storage_(storage) {}
    BoundedVector(const BoundedVector&) = delete;  // a copy would share the storage
    BoundedVector& operator=(const BoundedVector&) = delete;

    [[nodiscard]] constexpr bool try_push_back(const T& value) {
        if (full()) return false;
        storage_[size_++] = value;
        return true;
    }
    constexpr void push_back(const T& value) {
        TAKT_ASSERT(!full());
        storage_[size_++] = value;
    }
    /// Precondition: the free capacity holds all of `values`.
    constexpr void assign(std::span<const T> values) {
        TAKT_ASSERT(values.size() <= storage_.size());
        std::copy(values.begin(), values.end(), storage_.begin());
        size_ = values.size();
    }
    constexpr void clear() { size_ = 0; }

    [[nodiscard]] constexpr std::size_t size() const { return size_; }
    [[nodiscard]] constexpr bool empty() const { return size_ == 0; }
    [[nodiscard]] constexpr bool full() const { return size_ == storage_.size(); }
    [[nodiscard]] constexpr std::size_t capacity() const { return storage_.size(); }

    constexpr T& operator[](std::size_t index) {
        TAKT_ASSERT(index < size_);
        return storage_[index];
    }
    constexpr const T& operator[](std::size_t index) const {
        TAKT_ASSERT(index < size_);
        return storage_[index];
    }
    constexpr T& back() { return (*this)[size_ - 1]; }
    constexpr const T& back() const { return (*this)[size_ - 1]; }

    [[nodiscard]] constexpr std::span<const T> span() const { return storage_.first(size_); }

private:
    std::span<T> storage_;
    std::size_t size_ = 0;
};

}  // namespace takt
