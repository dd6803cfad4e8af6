// The bytes inside a TLS connection.
#pragma once

#include <utility>

#include "takt/line/byte_stream.hpp"
#include "takt/os/descriptor.hpp"
#include "takt/tls/connection.hpp"

namespace takt::line {

/// A socket with TLS whose handshake is done.
class TlsStream final : public ByteStream {
public:
    TlsStream(os::Descriptor socket, tls::Connection connection)
        : socket_(std::move(socket)), connection_(std::move(connection)) {}

    [[nodiscard]] int fd() const override { return socket_.get(); }
    [[nodiscard]] Result<std::size_t> read(std::span<std::uint8_t> buffer) override {
        return connection_.read(buffer);
    }
    [[nodiscard]] Result<std::size_t> write(Bytes bytes) override { return connection_.write(bytes); }
    [[nodiscard]] bool has_buffered() const override { return connection_.has_buffered(); }

private:
    os::Descriptor socket_;
    tls::Connection connection_;  // ends before the socket is closed
};

}  // namespace takt::line
