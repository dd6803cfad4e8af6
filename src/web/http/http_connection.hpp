// One connection of a browser: bytes to requests, answers and events to bytes.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include "http/request_head.hpp"
#include "takt/base/engine.hpp"
#include "takt/line/tcp_server.hpp"
#include "takt/web/api.hpp"
#include "takt/web/stream.hpp"

namespace takt::web {

struct HttpRequest {
    RequestHead head;
    std::string body = {};  ///< empty until it is complete
    std::string peer = {};  ///< address without the port
    // Known when it is admitted.
    std::string client = {};   ///< its address: the peer's, or behind a proxy
    std::string visitor = {};  ///< whose limits count
    Work work = Work::quick;
    bool is_stream = false;
    std::string superseded_by = {};  ///< RequestQueue::Entry
    std::stop_token stop = {};       ///< ApiRequest::stop
};

struct HttpReply {
    std::string bytes;  ///< status line, fields and body
    bool close = false;
    std::unique_ptr<StreamSource> stream = {};  ///< sent behind `bytes`, to the end of the connection
};

/// An HTTP/1.1 connection as an engine (takt/base/engine.hpp): no sockets, no threads, no clock.
///
/// A request is admitted by its head. Its body counts as it is received, not as it is announced.
///
/// Requests are executed one after another. While one is executed, few bytes are read, so that the end of the
/// connection is noticed. While its answer is sent, nothing is read.
/// A request that is not complete in time is answered with 408. The sending side of a connection ends
/// right after its last answer. Input that is on its way is dropped for a short time: closing at once could
/// destroy the answer.
class HttpConnection final : public line::Session, private Engine {
public:
    struct Limits {
        HeadLimits head;
        Duration idle = std::chrono::seconds(20);     ///< without a request
        Duration request = std::chrono::seconds(10);  ///< from the first byte of a request to its end
        Duration body = std::chrono::seconds(60);     ///< likewise of a request with a body over 64 KiB
        Duration linger = std::chrono::seconds(1);
    };
    /// Called on the thread of the connection.
    struct Owner {
        /// A request without its body. Fills in what is known when it is admitted.
        /// @returns the answer to a request that is refused
        std::function<std::optional<HttpReply>(HttpRequest&)> admit;
        /// Starts a request; answer() is called later.
        /// @returns 0, or the status of a request that cannot be executed now
        std::function<int(HttpRequest)> execute;
        /// Counts the bytes that the connections of a visitor hold.
        /// @returns 0, or the status of a request that may not hold so many
        std::function<int(std::string_view visitor, std::ptrdiff_t change)> reserve;
        /// The client has closed its sending side while a request is executed.
        std::function<void()> input_ended;
        std::function<void()> destroyed;
    };

    /// @param peer  "10.0.0.5:49152"
    HttpConnection(const Limits& limits, std::string_view peer, Instant t, Owner owner);
    ~HttpConnection() override;
    HttpConnection(const HttpConnection&) = delete;
    HttpConnection& operator=(const HttpConnection&) = delete;

    void answer(HttpReply reply);
    [[nodiscard]] bool streams() const { return stream_ != nullptr; }
    /// Of its last request.
    [[nodiscard]] const std::string& visitor() const { return visitor_; }
    /// When its client sent something last; nothing: a request is executed or its answer is sent.
    [[nodiscard]] std::optional<Instant> waits_since() const;
    /// Closes it. Not from inside of a call of the engine; it is destroyed.
    void drop();
    /// Fetches bytes and wake-up again. Not from inside of a call of the engine.
    void poke() const;

    // line::Session
    [[nodiscard]] Engine& engine() override { return *this; }
    [[nodiscard]] std::size_t wants_bytes() const override;
    [[nodiscard]] bool finished() const override;
    [[nodiscard]] bool output_ended() const override;
    [[nodiscard]] bool drained() const override;
    [[nodiscard]] Instant last_received() const override;
    void on_input_end() override;
    void attach(std::function<void()> poke) override { poke_ = std::move(poke); }

private:
    enum class State {
        receiving,
        executing,
        sending,
        lingering,  ///< the last answer is sent
        finished,
    };

    void on_link(Instant t, bool up) override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    [[nodiscard]] Bytes transmit(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override { return deadline_; }

    void receive(Instant t);
    [[nodiscard]] bool receive_head(Instant t);
    void refuse(HttpReply reply);
    void reject(int status);
    void begin_request();
    void sent(Instant t);
    [[nodiscard]] Bytes next_chunk();
    int hold(std::size_t bytes);

    Limits limits_;
    std::string peer_;
    Owner owner_;
    std::function<void()> poke_;
    State state_ = State::receiving;
    Instant deadline_;
    Instant last_received_;
    std::string input_;
    std::size_t scanned_ = 0;             // of input_, without an end of a head
    std::optional<HttpRequest> request_;  // whose body is being received
    std::string visitor_;
    std::string output_;
    std::size_t taken_ = 0;  // of output_, by the driver
    bool close_ = false;     // behind output_
    std::unique_ptr<StreamSource> stream_;
    std::size_t held_ = 0;  // bytes that the owner has counted for visitor_
};

}  // namespace takt::web
