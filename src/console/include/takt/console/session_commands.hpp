// Commands as lines of text (standard input, control socket), given to a host session.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include "takt/console/command_reader.hpp"
#include "takt/console/output_states.hpp"
#include "takt/host/session.hpp"

namespace takt::console {

/// Executes the lines of any number of text clients in one session, and gives each outcome to its client.
class SessionCommands {
public:
    /// As host::Session::snapshot().
    using TakeSnapshot = std::function<Result<host::Snapshot>(const host::SnapshotParts&)>;

    /// @param session   outlives it
    /// @param quit      what `quit` does
    /// @param snapshot  empty: of the session
    SessionCommands(host::Session& session, std::function<void()> quit, TakeSnapshot snapshot = {});

    /// The states of the project's outputs, for `status`. Empty: there are none.
    void set_outputs(OutputStates outputs) { outputs_ = std::move(outputs); }

    /// @returns the errors of parse_control()
    [[nodiscard]] Result<void> execute(const std::string& line, const Reply& reply, const Texts& texts);

    /// Answers the commands that have ended. Must be called when the session has something to read.
    void take_outcomes();

private:
    struct Waiting {
        Reply reply;
        host::ConfigurationPtr configuration;  // whose indices the outcome has
        Texts texts;
    };

    /// The answer to a command that asks for the state of the project.
    [[nodiscard]] Result<Answer> state(const ControlCommand& command, const Texts& texts) const;

    host::Session& session_;
    std::function<void()> quit_;
    TakeSnapshot snapshot_;
    OutputStates outputs_;
    std::map<std::uint64_t, Waiting> waiting_;  // by Command::tag
    std::uint64_t last_tag_ = 0;
};

}  // namespace takt::console
