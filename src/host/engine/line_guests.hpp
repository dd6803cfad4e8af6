// Requests of sessions to units of polled lines: a scan or a probe beside polling.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <utility>

#include "engine/host_link.hpp"
#include "takt/poll/master.hpp"

namespace takt::host {

/// One request at a time for each line, in the relay slot of its poller. A line with a gateway alternates
/// between both. The I/O thread only.
class LineGuests {
public:
    /// Gets each command with its outcome, from inside any member.
    using Finished = std::function<void(std::unique_ptr<CommandRequest>)>;
    /// The driver of a line has something to send.
    using Poke = std::function<void(std::size_t line)>;

    LineGuests(poll::Master& master, Finished finished, Poke poke)
        : master_(master), finished_(std::move(finished)), poke_(std::move(poke)) {}

    /// Accepts Command::Kind::exchange. The outcome is refused with queue_full while the line has one.
    void execute(Instant t, std::unique_ptr<CommandRequest> command);

    /// A request waits for the line, or is in the slot: a gateway must not submit its next one.
    [[nodiscard]] bool waits(std::size_t line) const { return waiting_.contains(line); }
    /// What is in the slot is a guest's.
    [[nodiscard]] bool in_slot(std::size_t line) const;

    /// Takes outcomes, and submits what waits. After every call of an engine, and each tick.
    void settle(Instant t);
    /// The run ends or the project changes: each request that was not sent has expired, others are unknown.
    void finish(Instant t);

private:
    struct Waiting {
        std::unique_ptr<CommandRequest> command;
        bool submitted = false;
    };

    void submit(Instant t, std::size_t line, Waiting& waiting);
    void end(std::map<std::size_t, Waiting>::iterator waiting, Instant t, value::CommandResult result,
             value::Reason reason);

    poll::Master& master_;
    Finished finished_;
    Poke poke_;
    std::map<std::size_t, Waiting> waiting_;  // by line
};

}  // namespace takt::host
