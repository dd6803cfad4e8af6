// Shared by the sessions and the I/O thread of a host: the rings, the mailboxes, and the flags that wake
// sessions.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "engine/mailbox.hpp"
#include "takt/host/broadcast_ring.hpp"
#include "takt/host/command.hpp"
#include "takt/host/configuration.hpp"
#include "takt/host/snapshot.hpp"
#include "takt/host/traffic.hpp"
#include "takt/os/descriptor.hpp"

namespace takt::host {

class HostLink;
class ProjectEngine;

/// Something that the I/O thread is to do.
struct HostRequest : MailboxNode {
    /// On the I/O thread. May keep itself alive by moving `self`.
    virtual void serve(ProjectEngine& engine, Instant t, std::unique_ptr<HostRequest> self) = 0;
    /// The host has stopped and will not serve it.
    virtual void refuse(HostLink& link, std::unique_ptr<HostRequest> self) = 0;
};

/// A command on its way to the I/O thread, and its outcome on the way back.
struct CommandRequest final : HostRequest {
    Command command;
    SessionId session = 0;
    std::uint32_t generation = 0;  // of the slot in `command`
    Outcome outcome;

    void serve(ProjectEngine& engine, Instant t, std::unique_ptr<HostRequest> self) override;
    void refuse(HostLink& link, std::unique_ptr<HostRequest> self) override;
};

/// The state of one session that the I/O thread uses.
struct SessionSlot {
    std::atomic<SessionId> id = 0;  // 0: free
    std::atomic<bool> armed = false;
    std::atomic<std::uint32_t> commands = 0;  // submitted, outcome not taken
    Mailbox<CommandRequest> outcomes;
    os::Descriptor bell;  // an eventfd; open from the first use to the end of the link
};

using EndpointNames = std::shared_ptr<const endpoint::Statistics>;

class HostLink {
public:
    static constexpr std::size_t kMostSessions = 64;
    static constexpr std::size_t kGenerations = 8;
    static constexpr std::size_t kRingWords = std::size_t{1} << 19;  // 4 MiB

    /// @param words  of each ring
    explicit HostLink(std::size_t words = kRingWords) : events(words), traffic(words) {}

    /// Any thread. @returns 0 when kMostSessions are open or there are no descriptors left
    [[nodiscard]] SessionId open_session();
    void close_session(SessionId id);
    [[nodiscard]] SessionSlot& slot(SessionId id) { return slots_[id % kMostSessions]; }

    /// Any thread. @returns false when the host has stopped: the request is dropped
    [[nodiscard]] bool post(std::unique_ptr<HostRequest> request);

    /// After the I/O thread has ended: refuses what arrived too late.
    void refuse_rest();

    /// The I/O thread: gives an outcome back to its session. The command's memory goes with it.
    void deliver(std::unique_ptr<CommandRequest> command);
    /// The I/O thread: wakes every session that waits.
    void notify();

    /// The configuration that runs. Any thread but the I/O thread.
    [[nodiscard]] ConfigurationPtr configuration() const { return configuration(generation); }
    /// One of the last kGenerations. @returns nullptr for an older one
    [[nodiscard]] ConfigurationPtr configuration(std::uint32_t number) const;
    void add_configuration(ConfigurationPtr configuration);

    /// The names and files of the endpoints that are open, with counters of zero: faces copy them into the
    /// memory of a snapshot. nullptr: there are no endpoints.
    [[nodiscard]] EndpointNames endpoint_names() const;
    void set_endpoint_names(EndpointNames names);

    /// The line of an endpoint's listener, for the texts of a traffic log. @returns TrafficSource::index
    std::size_t add_endpoint_line(const model::Line& line);
    /// @returns nothing when the configuration of the source is forgotten
    [[nodiscard]] std::optional<model::Line> line_of(const TrafficSource& source,
                                                     std::uint32_t generation) const;

    BroadcastRing events;
    BroadcastRing traffic;
    std::atomic<std::uint32_t> taps = 0;        // sessions that read `traffic`
    std::atomic<std::uint32_t> generation = 0;  // that runs
    std::atomic<CommandId> last_command = 0;
    Mailbox<HostRequest> requests;
    os::Descriptor bell;  // an eventfd that wakes the I/O thread; open as long as a session may ring it
    /// Instead of the bell, for a host without a thread: called by post() for a request that waits now. A
    /// session that blocks for its snapshot continues if the snapshot is served inside.
    std::function<void(const HostRequest& request)> on_posted;
    std::atomic<bool> stopped = false;  // no further request is accepted
    std::atomic<bool> ended = false;    // the I/O thread is gone

    /// After the host has stopped: a copy of what is left of it. @returns connection_lost when nothing is
    /// left
    [[nodiscard]] Result<Snapshot> last_state(const SnapshotParts& parts) const;
    void set_last_state(std::function<Snapshot(const SnapshotParts&)> source);

private:
    mutable std::mutex mutex_;  // taken by the I/O thread only while it opens or closes endpoints
    std::deque<ConfigurationPtr> configurations_;               // the newest last; guarded by mutex_
    std::function<Snapshot(const SnapshotParts&)> last_state_;  // likewise
    std::vector<model::Line> endpoint_lines_;                   // likewise; without devices' variables
    EndpointNames endpoint_names_;                              // likewise
    std::array<SessionSlot, kMostSessions> slots_;
    std::atomic<std::uint32_t> opened_ = 0;
};

}  // namespace takt::host
