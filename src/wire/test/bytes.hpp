// Frames as hex strings, for the tests of this module.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "hex.hpp"
#include "takt/base/engine.hpp"

namespace takt::wire {

using ByteVector = std::vector<std::uint8_t>;

using test::from_hex;
using test::to_hex;

/// A copy in a heap block of exactly its size: a sanitizer sees every step beyond the end.
class ExactBytes {
public:
    explicit ExactBytes(Bytes bytes) : bytes_(new std::uint8_t[bytes.size()]), size_(bytes.size()) {
        std::ranges::copy(bytes, bytes_.get());
    }
    operator Bytes() const { return {bytes_.get(), size_}; }  // NOLINT(*-explicit-*): stands for its bytes

private:
    std::unique_ptr<std::uint8_t[]> bytes_;
    std::size_t size_;
};

}  // namespace takt::wire
