#include "network/resolver.hpp"

#include <cerrno>
#include <mutex>
#include <utility>

#include "loop/loop_impl.hpp"
#include "takt/line/target.hpp"

namespace takt::line {

// Shared by the loop and the look-up thread. The loop clears `loop` under the mutex when it is destroyed, so
// the thread never posts to a destroyed loop. Only the loop's thread uses `callback`.
struct Resolver::Request : std::enable_shared_from_this<Resolver::Request> {
    std::mutex mutex;
    Loop* loop = nullptr;
    Callback callback;

    void answer(Result<std::vector<SocketAddress>> addresses) {
        const std::lock_guard lock(mutex);
        if (!loop) return;
        loop->post([self = shared_from_this(), addresses = std::move(addresses)]() mutable {
            if (const auto call = std::exchange(self->callback, {})) call(std::move(addresses));
        });
    }
};

Resolver::Resolver(Loop& loop, const std::string& host, std::uint16_t port, Callback callback)
    : request_(std::make_shared<Request>()) {
    request_->loop = &loop;
    request_->callback = std::move(callback);
    auto numeric = resolve(host, port, true);
    if (numeric) {
        request_->answer(std::move(numeric));
        return;
    }
    const bool posted = loop.impl().look_up(
        [request = request_, host, port] { request->answer(resolve(host, port, false)); });
    if (!posted) request_->answer(fail(Code::io_failed, host_and_port(host, port), EAGAIN));
}

Resolver::~Resolver() {
    const std::lock_guard lock(request_->mutex);
    request_->loop = nullptr;
    request_->callback = {};
}

}  // namespace takt::line
