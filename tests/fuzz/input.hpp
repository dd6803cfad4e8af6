// Shared by the fuzz targets: consumption of the input, and heap copies of exact size.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>

#include "takt/base/engine.hpp"

namespace takt::fuzz {

/// Ends the run if a property does not hold.
inline void require(bool holds) {
    if (!holds) std::abort();
}

/// A heap copy of exactly the size of the bytes, so that the sanitizer detects an access beyond its end.
class Exact {
public:
    explicit Exact(Bytes bytes)
        : bytes_(std::make_unique<std::uint8_t[]>(bytes.size())), size_(bytes.size()) {
        std::copy(bytes.begin(), bytes.end(), bytes_.get());
    }
    [[nodiscard]] Bytes span() const { return {bytes_.get(), size_}; }

private:
    std::unique_ptr<std::uint8_t[]> bytes_;
    std::size_t size_;
};

/// The bytes of an input one after the other; behind its end zeros.
class Input {
public:
    explicit Input(Bytes bytes) : left_(bytes) {}

    [[nodiscard]] bool empty() const { return left_.empty(); }
    std::uint8_t byte() {
        if (left_.empty()) return 0;
        const std::uint8_t first = left_.front();
        left_ = left_.subspan(1);
        return first;
    }
    std::uint16_t word() {
        const unsigned high = byte();
        return static_cast<std::uint16_t>(high << 8 | byte());
    }
    /// At most `count` of them.
    Bytes bytes(std::size_t count) {
        const Bytes taken = left_.first(std::min(count, left_.size()));
        left_ = left_.subspan(taken.size());
        return taken;
    }

private:
    Bytes left_;
};

}  // namespace takt::fuzz
