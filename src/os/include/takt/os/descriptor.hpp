// An open file descriptor with one owner.
#pragma once

#include <utility>

namespace takt::os {

/// Closes its descriptor when it goes out of scope. -1: none.
class Descriptor {
public:
    Descriptor() = default;
    explicit Descriptor(int number) : number_(number) {}
    ~Descriptor() { reset(); }
    Descriptor(Descriptor&& other) noexcept : number_(other.release()) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        if (this != &other) reset(other.release());
        return *this;
    }

    [[nodiscard]] int get() const { return number_; }
    explicit operator bool() const { return number_ >= 0; }

    /// Gives the descriptor away: it is not closed here any more.
    [[nodiscard]] int release() { return std::exchange(number_, -1); }
    /// Closes the old descriptor and owns `number` from now on.
    void reset(int number = -1);

private:
    int number_ = -1;
};

}  // namespace takt::os
