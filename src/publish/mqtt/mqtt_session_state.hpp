// The state of an MqttSession.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <optional>

#include "mqtt/broker_choice.hpp"
#include "outputs/live_queue.hpp"
#include "outputs/source_window.hpp"
#include "takt/publish/mqtt_session.hpp"

namespace takt::publish {

inline constexpr Instant kNotBlocked = Instant::min();

struct MqttSession::State {
    enum class Phase : std::uint8_t {
        off,
        waiting,      // for the next attempt
        connecting,   // for MqttConnected
        subscribing,  // for MqttSubscribed
        online,       // messages are sent
        draining,     // nothing more is sent; waits for the acknowledgements due
        farewell,     // waits for the acknowledgement of the published will
        closing,      // for MqttClosed
    };

    /// What a failure concerns. Each has its last failure, until something of its kind succeeds.
    enum class Concern : std::uint8_t { connection, message, subscription, live };
    static constexpr std::size_t kConcerns = 4;

    State(MqttSessionOptions the_options, MessageSource& the_source, MqttListener& the_listener);

    void connect(Instant now);
    void wait(Instant now, Duration pause_length);
    void close(Instant now, std::optional<MqttFailure> failure);
    void leave(Instant now, Duration limit);

    void on(Instant now, const MqttConnected& event);
    void on(Instant now, const MqttClosed& event);
    void on(Instant now, const MqttAcknowledged& event);
    void on(Instant now, MqttSubscribed&& event);
    void on(Instant now, MqttReceived&& event);
    void on(Instant now, MqttOversized&& event);
    void on_deadline(Instant now);
    [[nodiscard]] std::optional<MqttAction> next_action(Instant now);

    void enter(Instant now, Phase next);
    [[nodiscard]] MqttState shown() const;
    [[nodiscard]] bool is_expecting() const { return phase != Phase::off && phase != Phase::waiting; }
    [[nodiscard]] bool qos_0_only() const { return connected.maximum_qos == 0; }
    [[nodiscard]] std::size_t in_flight() const { return window.waiting() + live.in_flight(); }
    [[nodiscard]] std::size_t window_now() const;
    [[nodiscard]] std::size_t packet_limit() const;
    [[nodiscard]] bool is_due_first(MqttToken token) const;
    [[nodiscard]] Instant answer_deadline() const;
    [[nodiscard]] Instant return_deadline() const;

    void note(Instant now, Concern concern, MqttFailure failure);
    void succeeded(Concern concern) { failures[static_cast<std::size_t>(concern)].reset(); }
    [[nodiscard]] std::optional<MqttFailure> failure() const;
    void go_online(Instant now);
    bool on_live_settled(Instant now, const MqttAcknowledged& event);
    void slow_down(Instant now);
    void speed_up();
    void forget_connection(Instant now);
    void on_drained(Instant now);
    [[nodiscard]] MqttMessage adapted(MqttMessage message) const;
    [[nodiscard]] std::optional<MqttAction> publish_action(Instant now, MqttMessage&& message);
    [[nodiscard]] std::optional<MqttAction> next_live(Instant now);
    [[nodiscard]] std::optional<MqttAction> next_of_source(Instant now);

    MqttSessionOptions options;
    MessageSource& source;
    MqttListener& listener;
    BrokerChoice choice;  // refers to `options`
    SourceWindow window;
    LiveQueue live;

    Phase phase = Phase::off;
    Instant since{};
    Instant deadline = kNever;  // of the phase
    Instant progress{};  // the last acknowledgement that was due first, or the first message sent after it
    Instant blocked_until = kNotBlocked;  // a broker refused a message
    Duration pause;                       // after the next refused message
    std::size_t allowed = 0;              // messages in flight; shrinks when a broker refuses a message
    bool stopping = false;
    bool taken_over = false;

    // Of the connection.
    MqttConnectionId connection = 0;
    std::optional<MqttVersion> version;  // none: not open
    MqttConnected connected;
    bool subscribed = false;
    bool listened = false;                       // the listener was called with on_connected()
    std::optional<MqttFailure> pending_failure;  // why the session closed the connection
    MqttToken subscribe_token = 0;
    MqttToken farewell_token = 0;

    MqttToken last_token = 0;
    std::deque<MqttAction> actions;
    std::optional<MqttFailure> last_failure;
    std::array<std::optional<MqttFailure>, kConcerns> failures;  // by Concern
    Instant last_failure_at{};
    MqttOversized last_oversized;
    MqttCounters counters;
};

}  // namespace takt::publish
