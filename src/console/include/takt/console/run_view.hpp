// The output of `takt run`: JSON lines, text lines, or a table in place on a terminal.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "takt/console/command_reader.hpp"
#include "takt/console/keys.hpp"
#include "takt/console/output_states.hpp"
#include "takt/host/session.hpp"
#include "takt/os/record_writer.hpp"
#include "takt/report/drawing/panel.hpp"

namespace takt::console {

/// Gets what the session of the command line reads. The face's thread only.
class RunView {
public:
    virtual ~RunView() = default;

    virtual void on_event(const host::Configuration& configuration, const host::Event& event) = 0;
    virtual void on_missed(std::uint64_t events) = 0;
    /// The answer to a command from standard input.
    virtual void on_answer(Instant t, const Answer& answer) = 0;
    /// A key of the terminal. @returns false: it asks for the end
    virtual bool on_key(const Key& /*key*/) { return true; }
    /// About five times a second.
    virtual void refresh() {}
    /// State, failure or losses of an output are others than before.
    virtual void on_output(Instant t, const publish::OutputStatus& status) = 0;
    /// The last call.
    virtual void end(const host::Snapshot& last, const std::vector<publish::OutputStatus>& outputs) = 0;
};

/// Options of the writer for a view, with the lines that report what a slow reader missed.
[[nodiscard]] os::WriterOptions output_options(bool json);

/// The lines of a summary about outputs; empty without outputs.
[[nodiscard]] std::string outputs_summary(const Texts& texts,
                                          const std::vector<publish::OutputStatus>& outputs, Instant t,
                                          std::size_t columns);

/// One JSON object a line.
/// @param started  of the host
[[nodiscard]] std::unique_ptr<RunView> make_json_view(Instant started, const Texts& texts,
                                                      os::LineWriter& out);
/// One line of text for each change: for pipes and files.
/// @param screen  returns the size of the terminal, which the summary fits; empty: the output is no terminal
[[nodiscard]] std::unique_ptr<RunView> make_line_view(const Texts& texts, os::LineWriter& out,
                                                      std::function<report::Screen()> screen = {});
/// A display in place, for a terminal.
/// @param session    for snapshots; outlives the view
/// @param screen     returns the size of the terminal
/// @param selection  what is shown at first
/// @param outputs    empty: the project has none
[[nodiscard]] std::unique_ptr<RunView> make_live_view(host::Session& session, const Texts& texts,
                                                      os::LineWriter& out,
                                                      std::function<report::Screen()> screen,
                                                      report::LiveSelection selection = {},
                                                      OutputStates outputs = {});

}  // namespace takt::console
