// Where commands come from: standard input, and a Unix socket for `takt ctl`.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "takt/app/running.hpp"
#include "takt/line/loop.hpp"

namespace takt::app {

/// Executes lines of text; empty lines are nothing.
class CommandReader {
public:
    CommandReader(Running& running, const Texts& texts) : running_(running), texts_(texts) {}

    /// @param reply  gets the answer to every command found in `bytes`, in any order and perhaps later
    void feed(std::string_view bytes, const Reply& reply);

private:
    Running& running_;
    Texts texts_;
    LineSplitter splitter_;
};

/// Commands from standard input. At its end the run goes on without.
class StdinCommands {
public:
    StdinCommands(line::Loop& loop, Running& running, const Texts& texts, Reply reply);

private:
    void read();

    CommandReader reader_;
    Reply reply_;
    std::unique_ptr<line::Watch> watch_;
};

/// Commands from a Unix socket only its owner can open; at most kMaxClients at a time, each with a bounded
/// queue of answers.
class ControlServer {
public:
    static constexpr std::size_t kMaxClients = 16;

    /// A socket left behind by a program that is gone is replaced; anything else at the path is not touched.
    /// @returns busy (path) when another program listens there, cannot_open (path, errno)
    [[nodiscard]] static Result<std::unique_ptr<ControlServer>> listen(line::Loop& loop,
                                                                       const std::string& path,
                                                                       Running& running, const Texts& texts);
    /// Closes all clients and removes the socket.
    ~ControlServer();
    ControlServer(const ControlServer&) = delete;
    ControlServer& operator=(const ControlServer&) = delete;

private:
    struct Impl;
    explicit ControlServer(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace takt::app
