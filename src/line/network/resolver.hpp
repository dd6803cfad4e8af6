// Resolves names without blocking the loop.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "takt/line/loop.hpp"
#include "takt/line/socket.hpp"

namespace takt::line {

/// One look-up on a thread of its own. A name service that does not answer delays neither other look-ups nor
/// the end of the program. Destroying the resolver drops the result; the thread ends by itself.
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
