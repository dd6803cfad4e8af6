// A session on the real pipe, in real time.
#pragma once

#include <poll.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mqtt/mosquitto_pipe.hpp"
#include "session_rig.hpp"

namespace takt::publish {

class LiveSession final : public MqttListener {
public:
    explicit LiveSession(std::uint16_t port) {
        options.brokers = {{.host = "127.0.0.1", .port = port}};
        options.client_id = "takt-" + std::to_string(port);
        options.first_pause = 100ms;
        options.longest_pause = 400ms;
    }

    void on_connected(Instant, MqttConnectionId) override {}
    void on_disconnected(Instant, MqttConnectionId) override {}
    void on_message(Instant, MqttInbound&& message) override { inbound.push_back(std::move(message)); }

    void start() {
        pipe_ = std::make_unique<MosquittoPipe>();
        session_.emplace(options, source, *this);
        session_->start(now());
    }
    /// The pipe ends as with a program that is killed.
    void kill() { pipe_.reset(); }
    void stop() {
        session_->stop(now());
        EXPECT_TRUE(run([this] { return status().state == MqttState::off; }));
    }

    /// Runs until `done`. @returns false after `limit`
    template <class Done>
    bool run(Done done, Duration limit = 10s) {
        const Instant end = now() + limit;
        while (true) {
            while (auto event = pipe_->next_event()) session_->on_event(now(), std::move(*event));
            if (now() >= session_->next_wakeup()) session_->on_tick(now());
            while (auto action = session_->next_action(now())) pipe_->send(std::move(*action));
            if (done()) return true;
            if (now() >= end) return false;
            pollfd ready{.fd = pipe_->descriptor(), .events = POLLIN, .revents = 0};
            ::poll(&ready, 1, 5);
        }
    }
    bool connects(Duration limit = 10s) {
        return run([this] { return status().state == MqttState::connected; }, limit);
    }
    bool fails_with(MqttFailureKind kind) {
        if (!run([this] { return status().last_failure.has_value(); })) return false;
        EXPECT_EQ(name(status().last_failure->kind), name(kind)) << status().last_failure->text;
        return status().last_failure->kind == kind;
    }
    bool delivers_all(Duration limit = 300s) {
        return run([this] { return source.cursor == source.count; }, limit);
    }

    [[nodiscard]] MqttStatus status() const { return session_->status(); }
    MqttSession& session() { return *session_; }
    static Instant now() {
        return Instant(
            std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch()));
    }

    MqttSessionOptions options;
    NumberedSource source;
    std::vector<MqttInbound> inbound;

private:
    std::unique_ptr<MosquittoPipe> pipe_;
    std::optional<MqttSession> session_;
};

}  // namespace takt::publish
