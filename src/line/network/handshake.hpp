// Handshakes of TLS on the sockets of an event loop.
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <string>

#include "takt/line/byte_stream.hpp"
#include "takt/line/loop.hpp"
#include "takt/os/descriptor.hpp"
#include "takt/tls/connection.hpp"

namespace takt::line {

/// Called once, from the loop, with a stream or the errors of tls::Connection::handshake(), and the role of
/// the peer. It may destroy what calls it.
using Greeted = std::function<void(Result<std::unique_ptr<ByteStream>> stream, const std::string& role)>;

/// One handshake. It continues when the socket is ready, until it is done or has failed. It has no time limit
/// of its own: the owner destroys it. The loop's thread only.
class Handshake {
public:
    /// @param ready  called instead of step() when the socket is ready; empty: step() is called at once
    Handshake(Loop& loop, os::Descriptor socket, tls::Connection connection, std::function<void()> ready,
              Greeted done);

    /// Goes on. It may destroy the handshake.
    void step();

private:
    void on_ready() { ready_ ? ready_() : step(); }

    os::Descriptor socket_;
    tls::Connection connection_;
    std::function<void()> ready_;
    Greeted done_;
    std::optional<Watch> watch_;  // a descriptor has one at a time, and the stream gets its own
};

/// The handshakes of a server. A step costs up to some milliseconds of computing, so the loop takes one in a
/// turn, in which it also serves what else is ready: a flood of handshakes delays nothing by more than one
/// step. There are at most kMost. A further one ends the oldest that waits for its peer: silent peers
/// cannot block the others. The loop must outlive it. The loop's thread only.
class Handshakes {
public:
    static constexpr std::size_t kMost = 64;

    /// @param limit  of each handshake; then it fails as one with a peer that does not speak TLS
    Handshakes(Loop& loop, std::shared_ptr<const tls::Context> context, Duration limit);

    /// @param peer  the subject of errors
    void begin(os::Descriptor socket, const std::string& peer, Greeted done);

    /// Handshakes that are neither done nor failed.
    [[nodiscard]] std::size_t size() const { return pending_.size(); }

private:
    struct Pending {
        std::string peer;
        Instant ends;
        Greeted done;
        bool ready = false;
        std::optional<Handshake> handshake = std::nullopt;
    };
    using Entry = std::list<Pending>::iterator;

    void on_time(Instant t);
    void give_up(Entry entry);
    void end(Entry entry, Result<std::unique_ptr<ByteStream>> stream, const std::string& role);
    void arm();

    Loop& loop_;
    std::shared_ptr<const tls::Context> context_;
    Duration limit_;
    std::list<Pending> pending_;  // in the order of their ends
    Timer timer_;                 // the next turn, or the next end
};

}  // namespace takt::line
