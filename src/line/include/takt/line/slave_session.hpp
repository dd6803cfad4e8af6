// The slave engine on a connection of a TcpServer.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "takt/line/tcp_server.hpp"
#include "takt/serve/tcp_connection.hpp"

namespace takt::line {

class SlaveSession;

/// What the connections of a server share: rooms for those that are busy, who of them waits for which answer,
/// and what the closed ones counted. The loop's thread only.
class SlaveSessions final : public serve::TcpRooms, public serve::AnswerSink {
public:
    [[nodiscard]] serve::TcpRoom& lend() override;
    void give_back(serve::TcpRoom& room) override;

    /// Finds the connection in constant time, and lets it send.
    bool complete(serve::Token token, Bytes pdu) override;

    /// Of the connections that are closed.
    [[nodiscard]] const serve::Counters& counters() const { return counters_; }
    /// How many of them the engine ended for that reason; none: the peer did, or the server.
    [[nodiscard]] std::uint64_t closed(serve::CloseReason reason) const {
        return closed_[static_cast<std::size_t>(reason)];
    }

private:
    friend class SlaveSession;
    using Waiting = std::unordered_map<serve::Token, SlaveSession*>;
    static constexpr std::size_t kKept = 64;  // rooms that nobody needs are kept for the next, so many

    void add(const serve::TcpConnectionCore& connection);

    std::vector<std::unique_ptr<serve::TcpRoom>> free_;
    Waiting waiting_;  // at most one entry a connection
    serve::Counters counters_;
    std::array<std::uint64_t, serve::kCloseReasons> closed_{};
};

/// Answers the requests of one connection from a responder; what a server's factory makes.
class SlaveSession final : public Session, serve::Responder {
public:
    /// @param responder, sessions, observer  outlive the session; the observer may be nullptr
    SlaveSession(const serve::TcpConfig& config, serve::Responder& responder, SlaveSessions& sessions,
                 wire::TrafficObserver* observer = nullptr)
        : sessions_(sessions),
          responder_(responder),
          framer_storage_(std::make_unique<std::uint8_t[]>(wire::Framer::storage_size(config.framing))),
          connection_(config, *this, sessions,
                      {framer_storage_.get(), wire::Framer::storage_size(config.framing)}, observer) {}
    ~SlaveSession() override;
    SlaveSession(const SlaveSession&) = delete;
    SlaveSession& operator=(const SlaveSession&) = delete;

    [[nodiscard]] Engine& engine() override { return connection_; }
    [[nodiscard]] std::size_t wants_bytes() const override { return connection_.wants_bytes(); }
    [[nodiscard]] bool finished() const override {
        return connection_.close_reason() != serve::CloseReason::none;
    }
    void attach(std::function<void()> poke) override { poke_ = std::move(poke); }
    [[nodiscard]] const serve::TcpConnectionCore& connection() const { return connection_; }

private:
    friend class SlaveSessions;

    // serve::Responder: the one given, and what it leaves pending is remembered.
    [[nodiscard]] bool serves(UnitId unit) const override { return responder_.serves(unit); }
    [[nodiscard]] serve::Answer handle(const serve::Context& context, Bytes pdu) override;
    void heard(serve::LineEvent event) override { responder_.heard(event); }

    SlaveSessions& sessions_;
    serve::Responder& responder_;
    std::unique_ptr<std::uint8_t[]> framer_storage_;
    std::optional<serve::Token> waits_;        // for that answer
    SlaveSessions::Waiting::node_type spare_;  // of the map, used again and again
    std::function<void()> poke_;
    serve::TcpConnectionCore connection_;
};

}  // namespace takt::line
