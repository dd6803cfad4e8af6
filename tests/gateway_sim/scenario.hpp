// What a seed draws: the project, the settings of its output, and the troubles of the run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/faults/faults.hpp"
#include "takt/host/configuration.hpp"
#include "takt/publish/mqtt_session.hpp"
#include "takt/store/journal.hpp"

namespace takt::gatewaysim {

/// A broker as its operator set it up, and how it misbehaves.
struct BrokerTraits {
    bool speaks_5 = true;
    bool speaks_3_1_1 = true;
    bool closes_on_5 = false;  ///< an old one: it closes the connection without CONNACK
    publish::MqttConnected limits;
    Duration least_delay{};  ///< of a packet, one way
    Duration most_delay{};
    // Of a million messages.
    std::uint32_t lost_puback = 0;
    std::uint32_t repeated_puback = 0;
    std::uint32_t late_puback = 0;  ///< behind those of later messages
    std::uint32_t refused = 0;      ///< by a reason after which it is to be sent again
    std::uint32_t impossible = 0;   ///< by a reason after which it is never to be sent again
    std::uint32_t cut = 0;          ///< the connection ends before or after the message
    std::uint32_t repeated_command = 0;
    // Of a million connections.
    std::uint32_t not_accepted = 0;
    std::uint32_t no_answer = 0;     ///< to CONNECT
    std::uint32_t cut_early = 0;     ///< the connection ends before SUBACK
    std::uint32_t suback_fails = 0;  ///< a subscription is refused
    std::uint32_t stale_early = 0;   ///< commands of an earlier connection come before SUBACK
};

/// Mean distances of faults by the clock; zero: never.
struct TroubleMeans {
    Duration kill{};
    Duration power_cut{};
    Duration orderly_stop{};
    Duration clock_jump{};
    Duration disk_fails{};
    Duration disk_full{};
    Duration disk_slow{};
    Duration single_failure{};  ///< of one operation of the disk
    Duration sampler_stalls{};
    Duration output_stalls{};
    Duration broker_away{};
    Duration broker_forgets{};  ///< a restart without persistence
    Duration half_open{};       ///< a connection that loses everything until it is closed
    Duration cut{};             ///< of a connection
    Duration taken_over{};      ///< by another client with the same identifier
    Duration command{};
};

struct Scenario {
    std::uint64_t seed = 1;
    Instant begin;
    Instant quiet_from;  ///< no trouble begins after it, and what goes on ends
    Instant end;
    std::string text;   ///< of the project
    std::string error;  ///< empty: the project is legal
    host::ConfigurationPtr configuration;
    std::size_t ring_words = 0;  ///< of the host's events
    store::JournalOptions journal;
    std::size_t queue_bytes = 0;
    publish::MqttSessionOptions session;  ///< versions, window and times
    std::vector<BrokerTraits> brokers;    ///< as many as the project has
    TroubleMeans means;
    sim::FaultRates line_faults;
    bool damage = false;  ///< bytes change on the disk while the power is off
    bool retained_commands = false;
    Duration fast_step{};  ///< how often fast values change
};

/// How long a run is quiet at its end: all that was sampled before is then to be delivered.
inline constexpr Duration kQuiet = std::chrono::seconds(50);
/// The longest time for that.
inline constexpr Duration kProgress = std::chrono::seconds(40);

[[nodiscard]] Scenario draw_scenario(std::uint64_t seed, Duration length);

}  // namespace takt::gatewaysim
