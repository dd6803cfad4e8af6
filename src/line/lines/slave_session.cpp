// Pending answers are found by token in a map shared by all connections. Each session keeps its map node
// between requests, so that after the first one a pending answer needs no new node here. The responder has an
// entry of its own for each pending answer.
#include "takt/line/slave_session.hpp"

#include "takt/base/assert.hpp"

namespace takt::line {

serve::TcpBuffers& SlaveSessions::acquire() {
    if (free_.empty()) return *std::make_unique_for_overwrite<Buffers>().release();
    serve::TcpBuffers& buffers = *free_.back().release();
    free_.pop_back();
    return buffers;
}

void SlaveSessions::release(serve::TcpBuffers& buffers) {
    std::unique_ptr<Buffers> owned(static_cast<Buffers*>(&buffers));
    if (free_.size() < kKept) free_.push_back(std::move(owned));
}

void SlaveSessions::add(const serve::TcpConnectionCore& connection) {
    counters_.add(connection.counters());
    ++closed_[static_cast<std::size_t>(connection.close_reason())];
}

serve::Counters SlaveSessions::counters_now() const {
    serve::Counters all = counters_;
    for (const auto* const session : open_) all.add(session->connection().counters());
    return all;
}

bool SlaveSessions::complete(serve::Token token, Bytes pdu) {
    const auto found = waiting_.find(token);
    if (found == waiting_.end()) return false;
    SlaveSession& session = *found->second;
    session.spare_ = waiting_.extract(found);
    session.waits_.reset();
    const bool waited = session.connection_.complete(now(), token, pdu);
    if (waited && session.poke_) session.poke_();  // poke_() may destroy the session
    return waited;
}

serve::Answer SlaveSession::handle(const serve::Context& context, const wire::RequestView& request) {
    const serve::Answer answer = responder_.handle(context, request);
    if (answer.kind != serve::Answer::Kind::pending) return answer;
    TAKT_ASSERT(!waits_ && !sessions_.waiting_.contains(answer.token));
    if (spare_.empty()) {
        sessions_.waiting_.emplace(answer.token, this);
    } else {
        spare_.key() = answer.token;
        spare_.mapped() = this;
        sessions_.waiting_.insert(std::move(spare_));
    }
    waits_ = answer.token;
    return answer;
}

SlaveSession::~SlaveSession() {
    if (waits_) {
        sessions_.waiting_.erase(*waits_);
        responder_.forget(*waits_);
    }
    sessions_.open_.erase(this);
    sessions_.add(connection_);
}

}  // namespace takt::line
