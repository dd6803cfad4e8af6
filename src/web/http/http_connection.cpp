#include "http/http_connection.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "http/reply_text.hpp"
#include "takt/base/assert.hpp"

namespace takt::web {
namespace {

// What the driver copies if the socket accepts less; also the unit of its time limit for writing.
constexpr std::size_t kChunk = std::size_t{64} << 10;
constexpr std::size_t kSmallBody = std::size_t{64} << 10;
// Of requests behind the one that is executed.
constexpr std::size_t kMostPipelined = std::size_t{16} << 10;
constexpr std::string_view kLineEnd = "\r\n";
constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";

std::string host_of(std::string_view peer) {
    return std::string(peer.substr(0, peer.rfind(':')));
}

}  // namespace

std::string event_text(std::string_view name, std::string_view data) {
    std::string text;
    text.reserve(name.size() + data.size() + 17);
    return text.append("event: ").append(name).append("\ndata: ").append(data).append("\n\n");
}

HttpConnection::HttpConnection(const Limits& limits, std::string_view peer, Instant t, Owner owner)
    : limits_(limits),
      peer_(host_of(peer)),
      owner_(std::move(owner)),
      deadline_(after(t, limits.idle)),
      last_received_(t) {}

HttpConnection::~HttpConnection() {
    hold(0);
    owner_.destroyed();
}

void HttpConnection::poke() const {
    if (poke_) poke_();
}

std::optional<Instant> HttpConnection::waits_since() const {
    return state_ == State::receiving ? std::optional(last_received_) : std::nullopt;
}

void HttpConnection::drop() {
    state_ = State::finished;
    poke();
}

std::size_t HttpConnection::wants_bytes() const {
    if (state_ == State::executing) return kMostPipelined - std::min(kMostPipelined, input_.size());
    return state_ == State::receiving || state_ == State::lingering || stream_ ? SIZE_MAX : 0;
}

bool HttpConnection::finished() const {
    return state_ == State::finished;
}

bool HttpConnection::output_ended() const {
    return state_ == State::lingering;
}

// A stream ends as soon as its browser has closed its side.
bool HttpConnection::drained() const {
    return stream_ || state_ == State::receiving || state_ == State::finished || state_ == State::lingering;
}

// Between two requests the connection may be closed for a new one; a stream may not.
Instant HttpConnection::last_received() const {
    return stream_ ? line::now() : last_received_;
}

void HttpConnection::on_input_end() {
    if (state_ == State::executing) owner_.input_ended();
}

void HttpConnection::on_link(Instant /*t*/, bool up) {
    if (!up) state_ = State::finished;
}

void HttpConnection::on_bytes(Instant t, Bytes bytes) {
    last_received_ = t;
    if (state_ != State::receiving && state_ != State::executing) return;  // streams take no input
    if (state_ == State::receiving && input_.empty() && !request_) deadline_ = after(t, limits_.request);
    input_.append(bytes.begin(), bytes.end());
    if (state_ == State::receiving) receive(t);
}

// One request; what follows it waits in input_ until its answer is sent.
void HttpConnection::receive(Instant t) {
    if (!request_ && !receive_head(t)) return;
    const auto size = request_->head.body_bytes;
    if (const int status = hold(std::min(input_.size(), size)); status != 0) return reject(status);
    if (input_.size() >= size) begin_request();
}

/// @returns whether a head is there, and its request was admitted
bool HttpConnection::receive_head(Instant t) {
    // Empty lines behind the body of the request before (RFC 9112, 2.2). The last one stays until more is
    // there, so that the time of the request counts from it.
    while (input_.size() > kLineEnd.size() && input_.starts_with(kLineEnd)) {
        input_.erase(0, kLineEnd.size());
        scanned_ = 0;
    }
    const auto size = head_size(input_, scanned_);
    scanned_ = size ? 0 : input_.size();
    if (!size && input_.size() > limits_.head.head_bytes) reject(431);
    if (!size) return false;
    auto parsed = parse_head(std::string_view(input_).substr(0, *size), limits_.head);
    if (parsed.status != 0) {
        reject(parsed.status);
        return false;
    }
    input_.erase(0, *size);
    HttpRequest request{.head = std::move(parsed.head), .peer = peer_};
    auto refusal = owner_.admit(request);
    visitor_ = request.visitor;
    if (refusal) {
        refusal->close = refusal->close || request.head.body_bytes > 0;
        refuse(*std::move(refusal));
        return false;
    }
    const auto body_bytes = request.head.body_bytes;
    if (body_bytes > kSmallBody) deadline_ = after(t, limits_.body);
    if (request.head.expects_continue && input_.size() < body_bytes) output_ = kContinue;
    request_ = std::move(request);
    return true;
}

void HttpConnection::begin_request() {
    auto request = *std::exchange(request_, {});
    const auto size = request.head.body_bytes;
    if (input_.size() == size) {
        request.body = std::exchange(input_, {});
    } else {
        request.body = input_.substr(0, size);
        input_.erase(0, size);
    }
    state_ = State::executing;
    deadline_ = kNever;
    if (const int status = owner_.execute(std::move(request)); status != 0) reject(status);
}

// The body of a request that is refused is not received. What would follow it is lost with it.
void HttpConnection::refuse(HttpReply reply) {
    state_ = State::executing;
    deadline_ = kNever;
    if (reply.close) input_.clear();
    answer(std::move(reply));
}

void HttpConnection::reject(int status) {
    output_ += bare_reply(status);
    close_ = true;
    state_ = State::sending;
    deadline_ = kNever;
    input_ = {};
    request_.reset();
    hold(0);
}

void HttpConnection::answer(HttpReply reply) {
    if (state_ != State::executing) return;
    hold(reply.bytes.size());
    output_ = std::move(reply.bytes);
    taken_ = 0;
    close_ = reply.close;
    stream_ = std::move(reply.stream);
    state_ = State::sending;
}

Bytes HttpConnection::next_chunk() {
    const auto size = std::min(kChunk, output_.size() - taken_);
    const Bytes bytes(reinterpret_cast<const std::uint8_t*>(output_.data()) + taken_, size);
    taken_ += size;
    return bytes;
}

// The driver calls again when the socket has accepted the chunk before.
Bytes HttpConnection::transmit(Instant t) {
    if (taken_ == output_.size() && stream_) {
        output_.clear();
        taken_ = 0;
        if (!stream_->take(output_)) {
            stream_.reset();
            close_ = true;
        }
        hold(output_.size());
    }
    if (taken_ < output_.size()) return next_chunk();
    if (state_ == State::sending && !stream_) sent(t);
    if (taken_ < output_.size()) return next_chunk();  // of a request that was there already, and rejected
    return {};
}

void HttpConnection::sent(Instant t) {
    output_ = {};
    taken_ = 0;
    hold(0);
    if (close_) {
        state_ = State::lingering;
        deadline_ = after(t, limits_.linger);
        return;
    }
    state_ = State::receiving;
    deadline_ = after(t, input_.empty() ? limits_.idle : limits_.request);
    scanned_ = 0;
    if (!input_.empty()) receive(t);
}

void HttpConnection::on_tick(Instant t) {
    if (t < deadline_) return;
    if (state_ == State::receiving && (!input_.empty() || request_)) return reject(408);
    if (state_ == State::receiving || state_ == State::lingering) {
        state_ = State::finished;
        deadline_ = kNever;
    }
}

/// @returns as Owner::reserve
int HttpConnection::hold(std::size_t bytes) {
    const auto change = static_cast<std::ptrdiff_t>(bytes) - static_cast<std::ptrdiff_t>(held_);
    held_ = bytes;
    return owner_.reserve(visitor_, change);
}

}  // namespace takt::web
