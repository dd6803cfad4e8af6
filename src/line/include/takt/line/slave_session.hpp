// The slave engine on a connection of a TcpServer.
#pragma once

#include "takt/line/tcp_server.hpp"
#include "takt/serve/tcp_connection.hpp"

namespace takt::line {

/// Answers the requests of one connection from a responder; what a server's factory makes.
class SlaveSession final : public Session {
public:
    /// @param responder, observer  outlive the session; the observer may be nullptr
    SlaveSession(const serve::TcpConfig& config, serve::Responder& responder,
                 wire::TrafficObserver* observer = nullptr)
        : connection_(config, responder, observer) {}

    [[nodiscard]] Engine& engine() override { return connection_; }
    [[nodiscard]] std::size_t wants_bytes() const override { return connection_.wants_bytes(); }
    [[nodiscard]] bool finished() const override {
        return connection_.close_reason() != serve::CloseReason::none;
    }
    [[nodiscard]] const serve::TcpConnection& connection() const { return connection_; }

private:
    serve::TcpConnection connection_;
};

}  // namespace takt::line
