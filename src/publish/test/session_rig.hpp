// A session with a source of numbered messages, and a pipe in the hands of the test.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "takt/publish/mqtt_session.hpp"

namespace takt::publish {

using namespace std::chrono_literals;

/// Messages 1 to `count` with their number as payload. Checks that the cursor moves in order.
class NumberedSource final : public MessageSource {
public:
    std::uint64_t count = 0;
    std::uint64_t cursor = 0;
    std::uint64_t highest = 0;
    std::size_t rewinds = 0;
    std::map<std::uint64_t, MqttReason> rejected;
    std::function<void(MqttMessage&, std::uint64_t)> adapt = [](MqttMessage&, std::uint64_t) {};
    MessageLimits limits;

    std::optional<SourceMessage> next(Instant, const MessageLimits& its_limits) override {
        limits = its_limits;
        if (next_ > count) return {};
        SourceMessage message{.token = next_,
                              .repeated = next_ <= highest,
                              .message = {.topic = "data", .payload = std::to_string(next_)}};
        adapt(message.message, next_);
        highest = std::max(highest, next_++);
        return message;
    }
    void acknowledge(Instant, std::uint64_t token) override { move_to(token); }
    void reject(Instant, std::uint64_t token, MqttReason reason) override {
        move_to(token);
        rejected.emplace(token, reason);
    }
    void rewind() override {
        ++rewinds;
        next_ = cursor + 1;
    }

private:
    void move_to(std::uint64_t token) {
        EXPECT_EQ(token, cursor + 1) << "the cursor moves in order, once for each message";
        EXPECT_LT(token, next_);
        cursor = token;
    }

    std::uint64_t next_ = 1;
};

class SessionRig : public MqttListener {
public:
    SessionRig() {
        options.brokers = {{.host = "first"}};
        options.client_id = "takt";
        options.first_pause = 1s;
        options.longest_pause = 60s;
    }

    // Functions of the listener.
    void on_connected(Instant, MqttConnectionId its) override { connected.push_back(its); }
    void on_disconnected(Instant, MqttConnectionId its) override { disconnected.push_back(its); }
    void on_message(Instant, MqttInbound&& message) override { inbound.push_back(std::move(message)); }

    /// The session, made with the options at the first call.
    MqttSession& session() {
        if (!session_) session_.emplace(options, source, *this);
        return *session_;
    }
    MqttStatus status() { return session().status(); }

    void start() {
        session().start(now);
        take();
    }
    void stop() {
        session().stop(now);
        take();
    }
    /// Advances the time in steps of the session's wake-ups.
    void advance(Duration length) {
        const Instant end = now + length;
        for (int ticks = 0; session().next_wakeup() <= end; ++ticks) {
            ASSERT_LT(ticks, 10'000) << "the session wakes up for ever";
            now = std::max(now, session().next_wakeup());
            session().on_tick(now);
            take();
        }
        now = end;
    }
    void event(MqttEvent event) {
        session().on_event(now, std::move(event));
        take();
    }
    bool publish(LiveMessage live) {
        const bool accepted = session().publish(now, std::move(live));
        take();
        return accepted;
    }
    /// Adds messages to the source.
    void produce(std::uint64_t messages) {
        source.count += messages;
        take();
    }

    /// The next action, which must be of this kind.
    template <class Action>
    Action expect() {
        if (actions.empty() || !std::holds_alternative<Action>(actions.front())) {
            ADD_FAILURE() << "another action, or none";
            return {};
        }
        auto action = std::get<Action>(std::move(actions.front()));
        actions.pop_front();
        return action;
    }
    /// All waiting actions are publications; their payloads, separated by spaces.
    std::string published() {
        std::string text;
        while (!actions.empty()) {
            const auto action = expect<MqttPublish>();
            tokens[action.message.payload] = action.token;
            text += (text.empty() ? "" : " ") + action.message.payload;
        }
        return text;
    }
    /// The session connects, and the broker accepts.
    MqttConnect accept(MqttConnected answer = {}) {
        auto connect = expect<MqttConnect>();
        connection = answer.connection = connect.connection;
        event(answer);
        return connect;
    }
    void close(MqttFailureKind kind, MqttReason reason = MqttReason::success) {
        event(MqttClosed{connection, {kind, reason, {}}});
    }
    /// The attempt that waits fails.
    MqttConnect fail(MqttFailureKind kind, MqttReason reason = MqttReason::success) {
        auto connect = expect<MqttConnect>();
        connection = connect.connection;
        close(kind, reason);
        return connect;
    }
    /// Advances to the next attempt. @returns how long that took
    Duration until_attempt() {
        const Instant begin = now;
        while (actions.empty() && now - begin < 24h)
            advance(std::max<Duration>(status().next_attempt - now, 1ms));
        return now - begin;
    }
    /// Acknowledges published messages by their payloads.
    void acknowledge(const std::vector<std::string>& payloads, MqttReason reason = MqttReason::success) {
        for (const auto& payload : payloads) event(MqttAcknowledged{connection, tokens.at(payload), reason});
    }

    MqttSessionOptions options;
    NumberedSource source;
    Instant now{1000s};
    std::deque<MqttAction> actions;
    std::map<std::string, MqttToken> tokens;
    std::vector<MqttConnectionId> connected;
    std::vector<MqttConnectionId> disconnected;
    std::vector<MqttInbound> inbound;
    MqttConnectionId connection = 0;

private:
    void take() {
        while (auto action = session().next_action(now)) actions.push_back(std::move(*action));
    }

    std::optional<MqttSession> session_;
};

}  // namespace takt::publish
