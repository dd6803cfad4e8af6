// Which broker is tried next, how, and when.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "takt/publish/mqtt_session.hpp"

namespace takt::publish {

/// The brokers of a session in order of preference, what is known about each, and the pauses between
/// attempts: from first_pause doubling to longest_pause, each up to half shorter by the seed.
class BrokerChoice {
public:
    /// @param options  must outlive this object
    explicit BrokerChoice(const MqttSessionOptions& options);

    /// The broker of the current or next attempt.
    [[nodiscard]] std::size_t index() const { return index_; }
    /// The version of the current or next attempt.
    [[nodiscard]] MqttVersion version() const;
    /// The will as this broker takes it.
    [[nodiscard]] std::optional<MqttMessage> will() const;

    /// The attempt succeeded.
    void on_connected(Instant now);
    /// The attempt failed. @returns the pause before the next attempt, which may be at another broker or with
    /// another version
    /// @param nearby  see MqttClosed
    [[nodiscard]] Duration on_failed(const MqttFailure& failure, bool nearby);
    /// The connection is lost. @returns the pause before the attempt at the preferred broker
    [[nodiscard]] Duration on_lost(Instant now, const MqttFailure& failure);
    /// The connection was left for the preferred broker.
    void on_left() { index_ = 0; }
    /// When a connection to another broker is to be left for the preferred one; kNever: it is that one.
    [[nodiscard]] Instant return_at() const { return return_at_; }

private:
    static constexpr Duration kNoLimit = Duration::max();

    struct Known {
        std::optional<MqttVersion> version;  // of the last connection
        bool try_3_1_1 = false;              // the attempt with 5 failed so that 3.1.1 may work
        bool no_retain = false;              // it refused a retained will
        bool qos_0_only = false;             // it refused the QoS of the will
    };

    bool try_otherwise(const MqttFailure& failure);
    Duration next_pause(Duration least, Duration most = kNoLimit);
    std::uint64_t draw();

    const MqttSessionOptions& options_;
    std::vector<Known> known_;
    std::size_t index_ = 0;
    // Failures of this round.
    bool all_need_user_ = true;
    bool all_nearby_ = true;
    Duration pause_;
    Instant connected_at_{};
    Instant return_at_ = kNever;
    std::uint32_t failed_returns_ = 0;
    std::uint64_t random_;
};

}  // namespace takt::publish
