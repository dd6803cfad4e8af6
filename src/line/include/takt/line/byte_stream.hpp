// What a port and a socket have in common.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"

namespace takt::line {

/// Bytes in and out of an open port or connection, never blocking.
class ByteStream {
public:
    virtual ~ByteStream() = default;

    /// The descriptor to wait for.
    [[nodiscard]] virtual int fd() const = 0;

    /// Reads what is there, at most buffer.size() > 0 bytes.
    /// @returns the number of bytes, 0 when there are none now; connection_lost when the other side is
    /// gone, io_failed
    [[nodiscard]] virtual Result<std::size_t> read(std::span<std::uint8_t> buffer) = 0;

    /// Writes as much as is taken at once; 0: nothing now.
    [[nodiscard]] virtual Result<std::size_t> write(Bytes bytes) = 0;
};

}  // namespace takt::line
