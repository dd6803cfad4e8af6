// A running host on a terminal or a pipe: its events and values go out, commands come in.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "takt/base/result.hpp"
#include "takt/console/control_server.hpp"
#include "takt/console/input_commands.hpp"
#include "takt/console/keyboard.hpp"
#include "takt/console/messages.hpp"
#include "takt/console/run_view.hpp"
#include "takt/console/session_commands.hpp"
#include "takt/console/traffic_log.hpp"
#include "takt/endpoint/statistics.hpp"
#include "takt/host/session.hpp"
#include "takt/line/loop.hpp"
#include "takt/os/record_writer.hpp"
#include "takt/report/drawing/panel.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::console {

/// Connects the sessions of a host with a view, a traffic log and the sources of commands.
///
/// `quit`, and the end of the output's reader, stop the loop. The loop's thread only.
class HostConsole {
public:
    /// All that is referred to outlives the console.
    struct Environment {
        line::Loop& loop;
        os::LineWriter& out;  ///< with output_options()
        Messages messages;
        TrafficLog* traffic = nullptr;  ///< nullptr: frames are not logged
        /// As ProjectHost::open_session().
        std::function<Result<std::unique_ptr<host::Session>>(const host::SessionOptions&)> open_session;
        Instant started;       ///< of the host
        OutputStates outputs;  ///< empty: the project has none
    };
    struct Options {
        bool json = false;
        bool quiet = false;                      ///< no values: changes of state only
        std::string device;                      ///< events and values of this device only; empty: all
        bool in_place = false;                   ///< a table in place, with `screen`; else lines
        std::function<report::Screen()> screen;  ///< size of the terminal; empty: the output is no terminal
        std::optional<int> keys;                 ///< terminal whose keys move the table
        std::optional<int> commands;             ///< descriptor that commands are read from
        std::string control_path;                ///< Unix socket for commands; empty: none
    };

    HostConsole(const Texts& texts, Environment environment, Options options);

    /// @returns what open_session() and ControlServer::listen() return
    [[nodiscard]] Result<void> begin();

    /// Reads what is left after the host has stopped, and writes the summary.
    /// @param served  what its servers counted
    void end(const endpoint::Statistics& served);

private:
    /// What a change of an output is shown for.
    struct OutputSummary {
        publish::OutputState state{};
        std::string failure;
        std::optional<Error> journal_failure;
        bool disk_waits = false;
        bool has_gaps = false;
        std::string set_aside;
        std::uint64_t damaged = 0;
        friend bool operator==(const OutputSummary&, const OutputSummary&) = default;
    };

    void make_view();
    [[nodiscard]] bool is_shown(const host::Event& event);
    Result<void> begin_commands();
    void read_session();
    void read_control_session();
    void on_event(const host::Event& event);
    void put_served(const endpoint::Statistics& served);
    void report_output();
    void report_outputs(Instant t);
    void refresh(Instant t);

    Texts texts_;
    Environment environment_;
    Options options_;
    std::unique_ptr<host::Session> session_;
    std::unique_ptr<RunView> view_;
    std::optional<SessionCommands> commands_;
    std::unique_ptr<host::Session> control_session_;
    std::optional<SessionCommands> control_commands_;
    std::optional<TapLog> tap_;
    std::unique_ptr<ControlServer> control_;
    std::optional<InputCommands> input_;
    std::optional<Keyboard> keyboard_;
    struct ShownOutput {
        OutputSummary summary;
        std::uint64_t dropped = 0;
        Instant at{};
    };
    std::map<std::string, ShownOutput> outputs_;  // by output: what was shown last
    std::optional<line::Watch> readable_;
    std::optional<line::Watch> control_readable_;
    std::optional<line::Timer> refresh_;
    std::uint64_t missed_ = 0;
    int output_error_ = 0;  // that was reported
};

}  // namespace takt::console
