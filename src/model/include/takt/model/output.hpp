// Outputs of a project: where samples of its values are delivered, and what may come back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/model/device.hpp"
#include "takt/model/document.hpp"
#include "takt/model/topic.hpp"

namespace takt::model {

enum class OutputTransport : std::uint8_t {
    mqtt,
    history,  ///< a database beside the journal
};

[[nodiscard]] std::string_view name(OutputTransport transport);

/// An MQTT broker.
struct Broker {
    std::string host;  ///< name or address; IPv6 without brackets
    std::uint16_t port = 1883;
    bool tls = false;
    friend bool operator==(const Broker&, const Broker&) = default;
};

/// `mqtt://HOST:PORT` or `mqtts://HOST:PORT`, as written in a project.
[[nodiscard]] std::string url_of(const Broker& broker);

enum class MqttVersionChoice : std::uint8_t {
    automatic,  ///< 5, else 3.1.1
    v5,
    v3_1_1,
};

/// How samples of a topic that wait for the broker travel.
enum class Backlog : std::uint8_t {
    single,
    array,  ///< together in JSON arrays, but the last one alone; only if the topic is not retained
};

/// The connection of an output with transport mqtt. Paths are relative to the project's file; empty: none.
struct MqttSettings {
    std::vector<Broker> brokers;  ///< in order of preference; 1 to 8
    MqttVersionChoice version = MqttVersionChoice::automatic;
    std::string client_id;  ///< empty: one of its own, which stays the same over restarts
    std::string user;
    std::string password_file;  ///< the password is its first line
    std::string password_env;   ///< the password is in this environment variable
    std::string ca_file;        ///< of the issuers to trust; empty: those of the system
    std::string certificate_file;
    std::string key_file;
    std::string alpn;
    Duration keep_alive = std::chrono::seconds(30);
    Backoff backoff;  ///< pauses between attempts to connect
    /// The longest pause after a refused, unreachable or timed-out attempt at a nearby address
    /// (IpAddress::is_nearby); at least `backoff.first`.
    Duration nearby_limit = std::chrono::seconds(10);
    std::uint16_t in_flight = 64;  ///< messages that are not acknowledged
    Duration round_trip{};         ///< from a message to its acknowledgement; zero: unknown
    Backlog backlog = Backlog::single;
    /// What is not a sample has topics below it: see control_levels(). No sample has one of these topics.
    std::string control_topic;
    friend bool operator==(const MqttSettings&, const MqttSettings&) = default;
};

/// The levels below MqttSettings::control_topic that are not for samples.
[[nodiscard]] std::span<const std::string_view> control_levels();

/// When there is a sample of a value.
struct SamplingPolicy {
    bool on_change = true;
    Duration period{};      ///< zero: none
    Duration heartbeat{};   ///< a sample when the last one is that old; zero: none
    double dead_band = 0;   ///< of a number: one that differs by at most this is no change
    bool skip_bad = false;  ///< a value that is not good is not delivered
    friend bool operator==(const SamplingPolicy&, const SamplingPolicy&) = default;
};

/// What a message of an output with transport mqtt carries.
enum class MessageScope : std::uint8_t {
    variable,  ///< one variable; a topic for each
    device,    ///< variables of one device
    request,   ///< variables of one device that were read by one request
};

/// An entry of `select`, or the keys of the output itself where it has none.
struct OutputSelection {
    SourceLocation location;
    SamplingPolicy policy;
    // Of transport mqtt:
    TopicTemplate topic;
    MessageScope message = MessageScope::variable;
    bool retain = true;
    friend bool operator==(const OutputSelection&, const OutputSelection&) = default;
};

/// A variable of a line by its indices in the project.
struct PolledIndex {
    std::size_t line = 0;
    std::size_t device = 0;
    std::size_t variable = 0;
    friend constexpr auto operator<=>(const PolledIndex&, const PolledIndex&) = default;
};

/// A local, or a variable of a line.
using OutputSubject = std::variant<LocalIndex, PolledIndex>;

/// A value that an output delivers.
struct SelectedValue {
    OutputSubject subject;
    std::size_t selection = 0;  ///< index into Output::selections
    std::string topic;          ///< transport mqtt: of its messages
    friend bool operator==(const SelectedValue&, const SelectedValue&) = default;
};

/// The journal of an output.
struct JournalSettings {
    std::uint64_t quota = std::uint64_t{4096} << 20U;  ///< bytes on the disk
    /// Acknowledged data stays that long. Of transport history: values stay that long in the database.
    Duration retention = std::chrono::hours(7 * 24);
    std::uint64_t buffer = std::uint64_t{8} << 20U;  ///< bytes in memory that are not on the disk yet
    /// Relative to the project's file. The journal is in a folder of it that has the name of the output.
    /// Empty: journal_directory().
    std::string directory;
    friend bool operator==(const JournalSettings&, const JournalSettings&) = default;
};

/// The directory of journals beside a project file: `plant.journal` of `plant.yaml`.
[[nodiscard]] std::string journal_directory(std::string_view project_file);

struct Output {
    std::string name;  ///< of lower-case letters, digits, - and _; unique
    SourceLocation location;
    OutputTransport transport = OutputTransport::mqtt;
    MqttSettings mqtt;
    std::vector<OutputSelection> selections;  ///< at least one
    std::vector<SelectedValue> values;        ///< locals, then variables, in the order of the project
    /// What a command may set or write: locals, and variables with a write function. In the order of the
    /// project; empty: the output is read-only.
    std::vector<OutputSubject> commandable;
    Duration command_expiry = std::chrono::seconds(10);
    JournalSettings journal;
    friend bool operator==(const Output&, const Output&) = default;
};

struct Project;

/// The most samples that an output can have in the long run: of a value with `period` that many, on change at
/// most one for each read. A value that is read as fast as the line allows counts as read ten times a second,
/// one that is not read by period as changing once a second.
[[nodiscard]] double most_samples_per_second(const Project& project, const Output& output);

/// Bytes that the journal of an output needs for these samples. An estimate:
/// src/publish/outputs/sample_codec.cpp.
[[nodiscard]] double most_journal_bytes_per_second(const Project& project, const Output& output);

/// The messages of these samples that need an acknowledgement each. An estimate: values of a device or
/// request count once, arrays not at all.
[[nodiscard]] double most_messages_per_second(const Project& project, const Output& output);

}  // namespace takt::model
