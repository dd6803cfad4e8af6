// The common interface of serial ports and sockets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"

namespace takt::line {

/// Non-blocking input and output of an open port or connection.
class ByteStream {
public:
    virtual ~ByteStream() = default;

    /// The descriptor to wait for.
    [[nodiscard]] virtual int fd() const = 0;

    /// Reads the available bytes, at most buffer.size() > 0.
    /// @returns the number of bytes, 0: none now; connection_lost if the other side closed, io_failed
    [[nodiscard]] virtual Result<std::size_t> read(std::span<std::uint8_t> buffer) = 0;

    /// Writes as many bytes as are accepted now. @returns their number, possibly 0
    [[nodiscard]] virtual Result<std::size_t> write(Bytes bytes) = 0;

    /// Whether read() has bytes that no event of the descriptor will announce.
    [[nodiscard]] virtual bool has_buffered() const { return false; }
};

}  // namespace takt::line
