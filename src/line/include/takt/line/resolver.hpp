// Names to addresses without holding up the loop.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "takt/line/loop.hpp"
#include "takt/line/socket.hpp"

namespace takt::line {

/// One look-up on a thread of the loop's pool (32 threads, started as they are needed). A name service that
/// does not answer delays other look-ups only when it holds all of them, and never the end of the program.
/// Destroying the Resolver drops the answer.
class Resolver {
public:
    using Callback = std::function<void(Result<std::vector<SocketAddress>>)>;

    /// `callback` is called once, from the loop. A numeric address needs no thread. With 4096 look-ups
    /// waiting, a further one fails with io_failed (EAGAIN).
    Resolver(Loop& loop, const std::string& host, std::uint16_t port, Callback callback);
    ~Resolver();
    Resolver(const Resolver&) = delete;
    Resolver& operator=(const Resolver&) = delete;

private:
    struct Request;
    std::shared_ptr<Request> request_;
};

}  // namespace takt::line
