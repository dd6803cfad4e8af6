// A sequence of bounded length, stored in place.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <initializer_list>
#include <span>

#include "takt/base/assert.hpp"

namespace takt {

/// At most N elements of a trivially copyable type, stored in place; never allocates.
/// try_push_back() returns false when full; push_back() beyond the capacity is a programming error.
template <class T, std::size_t N>
class InplaceVector {
public:
    using value_type = T;

    constexpr InplaceVector() = default;
    constexpr InplaceVector(std::initializer_list<T> values) {
        append(std::span<const T>(values.begin(), values.size()));
    }

    [[nodiscard]] constexpr bool try_push_back(const T& value) {
        if (size_ == N) return false;
        items_[size_++] = value;
        return true;
    }
    constexpr void push_back(const T& value) {
        TAKT_ASSERT(size_ < N);
        items_[size_++] = value;
    }
    /// Appends all of `values`. Precondition: the free capacity holds them.
    constexpr void append(std::span<const T> values) {
        TAKT_ASSERT(values.size() <= N - size_);
        std::copy(values.begin(), values.end(), items_.begin() + size_);
        size_ += values.size();
    }
    constexpr void assign(std::span<const T> values) {
        size_ = 0;
        append(values);
    }
    /// New elements are value-initialised.
    constexpr void resize(std::size_t size) {
        TAKT_ASSERT(size <= N);
        if (size > size_) std::fill(items_.begin() + size_, items_.begin() + size, T{});
        size_ = size;
    }
    constexpr void pop_back() {
        TAKT_ASSERT(size_ > 0);
        --size_;
    }
    constexpr void clear() { size_ = 0; }
    /// Removes the first `count` elements; the others move up.
    constexpr void drop_front(std::size_t count) {
        TAKT_ASSERT(count <= size_);
        std::copy(items_.begin() + count, items_.begin() + size_, items_.begin());
        size_ -= count;
    }

    [[nodiscard]] constexpr std::size_t size() const { return size_; }
    [[nodiscard]] constexpr bool empty() const { return size_ == 0; }
    [[nodiscard]] constexpr bool full() const { return size_ == N; }
    static constexpr std::size_t capacity() { return N; }

    constexpr T& operator[](std::size_t index) {
        TAKT_ASSERT(index < size_);
        return items_[index];
    }
    constexpr const T& operator[](std::size_t index) const {
        TAKT_ASSERT(index < size_);
        return items_[index];
    }
    constexpr T& back() { return (*this)[size_ - 1]; }
    constexpr const T& back() const { return (*this)[size_ - 1]; }

    constexpr T* data() { return items_.data(); }
    constexpr const T* data() const { return items_.data(); }
    constexpr T* begin() { return items_.data(); }
    constexpr T* end() { return items_.data() + size_; }
    constexpr const T* begin() const { return items_.data(); }
    constexpr const T* end() const { return items_.data() + size_; }

    [[nodiscard]] constexpr std::span<const T> span() const { return {items_.data(), size_}; }

    friend constexpr bool operator==(const InplaceVector& a, const InplaceVector& b) {
        return std::equal(a.begin(), a.end(), b.begin(), b.end());
    }

private:
    std::array<T, N> items_{};
    std::size_t size_ = 0;
};

}  // namespace takt
