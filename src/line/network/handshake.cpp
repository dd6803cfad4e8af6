#include "network/handshake.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "network/tls_stream.hpp"

namespace takt::line {

Handshake::Handshake(Loop& loop, os::Descriptor socket, tls::Connection connection,
                     std::function<void()> ready, Greeted done)
    : socket_(std::move(socket)),
      connection_(std::move(connection)),
      ready_(std::move(ready)),
      done_(std::move(done)) {
    watch_.emplace(loop, socket_.get(), [this] { on_ready(); }, [this] { on_ready(); });
    watch_->want_write();  // a client speaks first, and a server is ready to
}

void Handshake::step() {
    const auto progress = connection_.handshake();
    if (progress == tls::Connection::Progress::wants_read) return watch_->want_read();
    if (progress == tls::Connection::Progress::wants_write) return watch_->want_write();
    watch_.reset();
    const auto done = std::move(done_);
    if (!progress) return done(std::unexpected(progress.error()), {});
    const std::string role = connection_.role();
    auto stream = std::make_unique<TlsStream>(std::move(socket_), std::move(connection_));
    done(std::move(stream), role);
}

Handshakes::Handshakes(Loop& loop, std::shared_ptr<const tls::Context> context, Duration limit)
    : loop_(loop),
      context_(std::move(context)),
      limit_(limit),
      timer_(loop, [this](Instant t) { on_time(t); }) {}

void Handshakes::begin(os::Descriptor socket, const std::string& peer, Greeted done) {
    auto connection = tls::Connection::begin(context_, socket.get(), {}, peer);
    if (!connection) return done(std::unexpected(connection.error()), {});
    if (pending_.size() >= kMost) {
        const auto waits = std::ranges::find(pending_, false, &Pending::ready);
        give_up(waits == pending_.end() ? pending_.begin() : waits);
    }
    pending_.emplace_back(peer, after(now(), limit_), std::move(done));
    const auto entry = std::prev(pending_.end());
    entry->handshake.emplace(
        loop_, std::move(socket), *std::move(connection),
        [this, entry] {
            entry->ready = true;
            arm();
        },
        [this, entry](Result<std::unique_ptr<ByteStream>> stream, const std::string& role) {
            end(entry, std::move(stream), role);
        });
    arm();
}

void Handshakes::on_time(Instant t) {
    if (!pending_.empty() && pending_.front().ends <= t) return give_up(pending_.begin());
    const auto next = std::ranges::find(pending_, true, &Pending::ready);
    if (next == pending_.end()) return arm();
    next->ready = false;
    next->handshake->step();
    arm();
}

void Handshakes::give_up(Entry entry) {
    const std::string peer = entry->peer;
    end(entry, fail(Code::tls_failed, peer, static_cast<int>(TlsFault::not_tls)), {});
}

// The owner may begin others in `done`, but not destroy this object.
void Handshakes::end(Entry entry, Result<std::unique_ptr<ByteStream>> stream, const std::string& role) {
    const Greeted done = std::move(entry->done);
    pending_.erase(entry);
    done(std::move(stream), role);
    arm();
}

void Handshakes::arm() {
    const bool ready = std::ranges::find(pending_, true, &Pending::ready) != pending_.end();
    timer_.set(ready ? now() : pending_.empty() ? kNever : pending_.front().ends);
}

}  // namespace takt::line
