// Where commands come from: standard input, and a Unix socket for `takt ctl`.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "takt/app/control.hpp"
#include "takt/app/texts.hpp"
#include "takt/base/result.hpp"
#include "takt/file/json.hpp"
#include "takt/line/loop.hpp"

namespace takt::app {

/// The answer to one command, for both kinds of readers.
struct Answer {
    std::string line;  ///< with its line end
    file::Json json;
};

/// Gets the answer to one command; may be called later, and is not called when the run ends before.
using Reply = std::function<void(const Answer&)>;

/// Carries out one line of text.
/// @returns the error of a line that is no command; then `reply` is not called
using Execute = std::function<Result<void>(const std::string& line, const Reply& reply)>;

[[nodiscard]] Answer error_answer(const Texts& texts, const Error& error);
[[nodiscard]] Answer quit_answer();

/// Executes lines of text; empty lines are ignored. Errors are answered.
class CommandReader {
public:
    CommandReader(Execute execute, const Texts& texts) : execute_(std::move(execute)), texts_(texts) {}

    /// @param reply  gets the answer to every command found in `bytes`, in any order and perhaps later
    /// @returns how many were found
    std::size_t feed(std::string_view bytes, const Reply& reply);

private:
    Execute execute_;
    Texts texts_;
    LineSplitter splitter_;
};

/// Commands from standard input. At its end the run continues without.
class StdinCommands {
public:
    StdinCommands(line::Loop& loop, Execute execute, const Texts& texts, Reply reply);

private:
    void read();

    CommandReader reader_;
    Reply reply_;
    std::unique_ptr<line::Watch> watch_;
};

/// Commands from a Unix socket only its owner can open; at most kMaxClients at a time, each with a bounded
/// queue of answers. One more takes the place of the client that has been idle for the longest time; if no client
/// is idle, the new one is refused. The closed client gets an error that says why.
class ControlServer {
public:
    static constexpr std::size_t kMaxClients = 16;

    /// A socket left behind by a program that is gone is replaced; anything else at the path is not touched.
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

}  // namespace takt::app
