// The connection of one face (command line, page, broker, library) to a running host.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/host/broadcast_ring.hpp"
#include "takt/host/command.hpp"
#include "takt/host/configuration.hpp"
#include "takt/host/event.hpp"
#include "takt/host/snapshot.hpp"
#include "takt/host/traffic.hpp"

namespace takt::host {

class HostLink;

struct SessionOptions {
    bool events = true;           ///< false: for commands and snapshots only
    bool traffic = false;         ///< a tap on the frames of all lines and endpoints
    bool from_beginning = false;  ///< events from the oldest that is left, not from now on
};

/// Commands to a host, its events and snapshots. A session that is never read costs the host nothing: the
/// events it missed are counted, its outcomes are kept (at most kMostCommands).
///
/// Threads: one thread at a time uses a session; sessions do not share anything. It may outlive the host;
/// then it gives what is left to be read, and refuses commands.
class Session {
public:
    /// Commands without an outcome, or whose outcome was not taken.
    static constexpr std::size_t kMostCommands = 4096;

    explicit Session(std::shared_ptr<HostLink> link, std::uint32_t id, const SessionOptions& options);
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    [[nodiscard]] SessionId id() const { return id_; }

    /// The configuration of the last event that was read; at first the current one. Of a session without
    /// events the current one: two calls may differ, and submit() takes the indices of the last call.
    [[nodiscard]] const ConfigurationPtr& configuration() const;

    /// Gives a command to the host. Its outcome comes from next_outcome(), in any order.
    /// @returns its id (0 for get); queue_full (kMostCommands), connection_lost when the host has stopped
    [[nodiscard]] Result<CommandId> submit(const Command& command);

    [[nodiscard]] std::optional<Outcome> next_outcome();
    [[nodiscard]] std::optional<Event> next_event();
    [[nodiscard]] std::optional<TrafficRecord> next_traffic();

    /// The line of a record's source: name, port, framing and devices.
    /// @returns nothing when its project was replaced too long ago
    [[nodiscard]] std::optional<model::Line> line_of(const TrafficRecord& record) const;

    /// Events and frames that were overwritten before this session read them.
    [[nodiscard]] std::uint64_t missed_events() const { return events_.missed; }
    [[nodiscard]] std::uint64_t missed_traffic() const { return traffic_.missed; }

    /// Asks the host for a copy. Blocks until it is there.
    /// @returns timed_out after `limit`. After the host has stopped: its last state
    [[nodiscard]] Result<Snapshot> snapshot(const SnapshotParts& parts,
                                            Duration limit = std::chrono::seconds(5));

    /// A descriptor that becomes readable when something can be read here; for poll() and event loops. Call
    /// rearm() after each time it was readable, and whenever everything was read.
    [[nodiscard]] int descriptor() const;
    /// @returns true when there is something to read already: the descriptor may stay silent then
    [[nodiscard]] bool rearm();

    /// Blocks until something can be read, for at most `limit`. @returns whether there is something
    bool wait(Duration limit);

private:
    [[nodiscard]] bool has_more() const;

    std::shared_ptr<HostLink> link_;
    SessionId id_;
    bool listens_;
    bool tap_;
    BroadcastRing::Cursor events_;
    BroadcastRing::Cursor traffic_;
    mutable ConfigurationPtr configuration_;
    std::vector<std::uint64_t> record_;  // scratch
};

}  // namespace takt::host
