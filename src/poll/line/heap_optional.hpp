// An optional value on the heap, for members that few objects have.
#pragma once

#include <memory>
#include <utility>

namespace takt::poll {

/// An optional T in the size of a pointer. Copies are deep.
template <typename T>
class HeapOptional {
public:
    HeapOptional() = default;
    explicit HeapOptional(T value) : held_(std::make_unique<T>(std::move(value))) {}
    HeapOptional(const HeapOptional& other)
        : held_(other.held_ ? std::make_unique<T>(*other.held_) : nullptr) {}
    HeapOptional(HeapOptional&&) noexcept = default;
    HeapOptional& operator=(HeapOptional other) noexcept {
        held_ = std::move(other.held_);
        return *this;
    }
    ~HeapOptional() = default;

    explicit operator bool() const { return held_ != nullptr; }
    T& operator*() { return *held_; }
    const T& operator*() const { return *held_; }
    T* operator->() { return held_.get(); }
    const T* operator->() const { return held_.get(); }

private:
    std::unique_ptr<T> held_;
};

}  // namespace takt::poll
