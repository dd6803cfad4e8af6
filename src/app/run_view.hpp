// What a user of `takt run` sees: JSON lines, text lines, or a table in place on a terminal.
#pragma once

#include <memory>
#include <string>

#include "takt/app/control_server.hpp"
#include "takt/app/texts.hpp"
#include "takt/host/session.hpp"
#include "takt/os/record_writer.hpp"

namespace takt::app {

/// Gets what the session of the command line reads. The face's thread only.
class RunView {
public:
    virtual ~RunView() = default;

    virtual void on_event(const host::Configuration& configuration, const host::Event& event) = 0;
    virtual void on_missed(std::uint64_t events) = 0;
    /// The answer to a command from standard input.
    virtual void on_answer(Instant t, const Answer& answer) = 0;
    /// About five times a second.
    virtual void refresh() {}
    /// The last call.
    virtual void end(const host::Snapshot& last) = 0;
};

/// @param started  of the host
[[nodiscard]] std::unique_ptr<RunView> make_json_view(Instant started, const Texts& texts, os::LineWriter& out);
[[nodiscard]] std::unique_ptr<RunView> make_line_view(const Texts& texts, os::LineWriter& out);
/// For a terminal on stdout.
/// @param session  for snapshots of the values; outlives the view
[[nodiscard]] std::unique_ptr<RunView> make_live_view(host::Session& session, const Texts& texts,
                                                      os::LineWriter& out);

}  // namespace takt::app
