// Commands from a Unix socket, for `takt ctl`.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "takt/base/result.hpp"
#include "takt/console/command_reader.hpp"
#include "takt/line/loop.hpp"

namespace takt::console {

/// Commands from a Unix socket that only its owner can open; at most kMaxClients at a time, each with a
/// bounded queue of answers: a client that does not read them is cut off. A client with 64 commands without
/// an answer is not read until one is answered.
///
/// A client that has closed its sending side gets its answers. A client that has closed the socket is removed
/// at once; its commands in flight are completed without an answer.
///
/// One more client takes the place of the one that has been idle for the longest time; if no client is idle,
/// the new one is refused. The closed client gets an error with the reason.
class ControlServer {
public:
    static constexpr std::size_t kMaxClients = 16;

    /// Replaces a socket that no program listens on; anything else at the path is not touched.
    /// @returns busy (path) when another program listens there, cannot_open (path, errno)
    [[nodiscard]] static Result<std::unique_ptr<ControlServer>> listen(line::Loop& loop,
                                                                       const std::string& path,
                                                                       Execute execute, const Texts& texts);
    /// Closes all clients and removes the socket.
    ~ControlServer();
    ControlServer(const ControlServer&) = delete;
    ControlServer& operator=(const ControlServer&) = delete;

private:
    struct Impl;
    explicit ControlServer(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace takt::console
