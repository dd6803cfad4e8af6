// The slave engine on a connection of a TcpServer.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "takt/line/tcp_server.hpp"
#include "takt/serve/tcp_connection.hpp"

namespace takt::line {

class SlaveSession;

/// Shared by the connections of a server: buffers for the busy ones, the pending answers by token, and the
/// counters of the closed ones. The loop's thread only.
class SlaveSessions final : public serve::TcpBufferPool, public serve::AnswerSink {
public:
    [[nodiscard]] serve::TcpBuffers& acquire() override;
    void release(serve::TcpBuffers& buffers) override;

    /// Finds the connection of the token in constant time and lets it send.
    bool complete(serve::Token token, Bytes pdu) override;

    /// The counters of the closed connections.
    [[nodiscard]] const serve::Counters& counters() const { return counters_; }
    /// The counters of all connections, open or closed.
    [[nodiscard]] serve::Counters counters_now() const;
    /// Connections that the engine closed for that reason; none: the peer or the server closed them.
    [[nodiscard]] std::uint64_t closed(serve::CloseReason reason) const {
        return closed_[static_cast<std::size_t>(reason)];
    }

private:
    friend class SlaveSession;
    using Buffers = serve::StoredTcpBuffers<>;
    using Waiting = std::unordered_map<serve::Token, SlaveSession*>;
    static constexpr std::size_t kKept = 64;  // limit of unused buffers kept for later connections

    void add(const serve::TcpConnectionCore& connection);

    std::vector<std::unique_ptr<Buffers>> free_;
    Waiting waiting_;  // at most one entry a connection
    std::unordered_set<const SlaveSession*> open_;
    serve::Counters counters_;
    std::array<std::uint64_t, serve::kCloseReasons> closed_{};
};

/// Answers the requests of one connection from a responder. Made by a server's factory.
class SlaveSession final : public Session, serve::Responder {
public:
    /// @param responder, sessions, observer  outlive the session; the observer may be nullptr
    SlaveSession(const serve::TcpConfig& config, serve::Responder& responder, SlaveSessions& sessions,
                 wire::TrafficObserver* observer = nullptr)
        : sessions_(sessions),
          responder_(responder),
          framer_storage_(std::make_unique<std::uint8_t[]>(wire::Framer::storage_size(config.framing))),
          connection_(config, *this, sessions,
                      {framer_storage_.get(), wire::Framer::storage_size(config.framing)}, observer) {
        sessions_.open_.insert(this);
    }
    ~SlaveSession() override;
    SlaveSession(const SlaveSession&) = delete;
    SlaveSession& operator=(const SlaveSession&) = delete;

    [[nodiscard]] Engine& engine() override { return connection_; }
    [[nodiscard]] std::size_t wants_bytes() const override { return connection_.wants_bytes(); }
    [[nodiscard]] bool finished() const override {
        return connection_.close_reason() != serve::CloseReason::none;
    }
    [[nodiscard]] bool drained() const override { return connection_.drained(); }
    [[nodiscard]] Instant last_received() const override { return connection_.last_received(); }
    void attach(std::function<void()> poke) override { poke_ = std::move(poke); }
    [[nodiscard]] const serve::TcpConnectionCore& connection() const { return connection_; }

private:
    friend class SlaveSessions;

    // serve::Responder: forwards to the given responder and notes pending answers.
    [[nodiscard]] bool serves(UnitId unit) const override { return responder_.serves(unit); }
    [[nodiscard]] serve::Answer handle(const serve::Context& context,
                                       const wire::RequestView& request) override;
    void on_line_event(serve::LineEvent event) override { responder_.on_line_event(event); }

    SlaveSessions& sessions_;
    serve::Responder& responder_;
    std::unique_ptr<std::uint8_t[]> framer_storage_;
    std::optional<serve::Token> waits_;        // for that answer
    SlaveSessions::Waiting::node_type spare_;  // of the map, used again and again
    std::function<void()> poke_;
    serve::TcpConnectionCore connection_;
};

}  // namespace takt::line
