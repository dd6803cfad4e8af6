// The commands of an output, from their messages to their answers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "takt/base/time.hpp"
#include "takt/host/command.hpp"
#include "takt/publish/command_target.hpp"
#include "takt/publish/mqtt_session.hpp"

namespace takt::publish {

/// One moment in both clocks.
struct CommandTime {
    Instant t;
    std::int64_t wall_ns = 0;
};

struct CommandDeskOptions {
    std::string output;         ///< its name
    std::string control_topic;  ///< commands arrive at <control_topic>/command and /set/<variable>
    Duration expiry = std::chrono::seconds(10);  ///< of a command that has no other; > 0
    std::string id_prefix;                       ///< of ids that the desk makes; another one in each run
    /// Writes one line for each command. @returns whether it was written. May be empty
    std::function<bool(std::string_view line)> audit;
};

struct CommandCounters {
    std::uint64_t received = 0;  ///< messages; repeated ones included
    std::uint64_t refused = 0;   ///< of them, before the host got them
    std::uint64_t answers_dropped = 0;
    std::uint64_t unrecorded = 0;  ///< without a line in the audit log
};

/// Checks each command, hands it to the host and answers it.
///
///   - Each command has exactly one outcome. The same id with the same content gets the same answer again and
///     is not executed again, within CommandMemory::kMost accepted commands.
///   - Retained commands, commands of an earlier connection, and expired ones are not executed.
///   - Each command has a line in the audit log. Lines that could not be written are counted; the next one
///     that can be written is preceded by their number.
///   - Answers wait for the connection: at most kMostAnswers and kMostAnswerBytes, the oldest are dropped and
///     counted.
///
/// No clock, thread or socket. After each call the owner submits next_command() to the host until there is
/// none, and takes answers when it can publish. One owner, one thread.
class CommandDesk {
public:
    static constexpr std::size_t kMostOpen = 256;      ///< commands without an outcome
    static constexpr std::size_t kMostAnswers = 1024;  ///< that wait for the broker
    static constexpr std::size_t kMostAnswerBytes = std::size_t{384} << 10U;
    static constexpr std::size_t kLongestReply = 1024;             ///< response topic and correlation data
    static constexpr Duration kFuture = std::chrono::seconds(60);  ///< clocks may differ by that much

    explicit CommandDesk(CommandDeskOptions options);
    CommandDesk(CommandDesk&&) noexcept;
    CommandDesk& operator=(CommandDesk&&) noexcept;
    ~CommandDesk();

    /// Before the first message, and when another configuration runs.
    void set_rights(CommandRights rights);

    /// @param broker  for the audit log
    /// @returns false: the message is not at a topic of commands
    bool on_message(const CommandTime& now, std::string_view broker, const MqttInbound& inbound);

    /// The next command for the host, with a tag. Commands that have expired meanwhile are answered.
    [[nodiscard]] std::optional<host::Command> next_command(const CommandTime& now);
    /// The host did not take it.
    void on_rejected(const CommandTime& now, std::uint64_t tag, const Error& error);
    void on_outcome(const CommandTime& now, const host::Outcome& outcome);

    /// Open commands end: as unknown those that the host has, as refused all others. Later ones are ignored.
    void stop(const CommandTime& now);

    /// The oldest answer that waits; nullptr: none.
    [[nodiscard]] const LiveMessage* first_answer() const;
    void remove_first_answer();

    [[nodiscard]] std::size_t open() const;
    [[nodiscard]] CommandCounters counters() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace takt::publish
