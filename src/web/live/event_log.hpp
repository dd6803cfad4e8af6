// Makes marks of what happens: messages, and commands with their outcomes.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>

#include "live/marks.hpp"
#include "takt/os/ticker.hpp"
#include "takt/web/host_access.hpp"

namespace takt::web {

/// Commands of browsers come from the API. A thread of its own reads the events of the host: messages, writes
/// of other faces to devices, and `set` commands of theirs that failed. The host has no event for a `set`
/// that succeeded.
class EventLog {
public:
    static constexpr int kMostMessages = 20;  // in a tick; a flood of messages must not bury the others
    static constexpr auto kTick = std::chrono::milliseconds(250);

    /// @param marks  must outlive this object
    EventLog(HostAccess host, Marks& marks);
    /// Reads the last events and ends the thread. A second call does nothing.
    void end() { ticker_.end(); }

    /// The API reports the commands of this session itself. Called before its first command. Any thread.
    void own(host::SessionId session);
    /// A command of a browser. Any thread.
    void add(const host::Outcome& outcome, const host::Configuration& configuration, std::string address);

private:
    void work();
    void read_events();
    void add(const host::Event& event);
    void add_command(const host::Outcome& outcome, const host::Configuration& configuration,
                     std::string origin);
    [[nodiscard]] bool is_own(host::SessionId session) const;

    HostAccess host_;
    Marks& marks_;
    std::unique_ptr<host::Session> session_;  // of the thread
    std::uint64_t missed_ = 0;                // likewise
    int messages_ = 0;                        // of this tick, likewise
    mutable std::mutex mutex_;                // of `own_`
    std::deque<host::SessionId> own_;         // the newest ones
    os::Ticker ticker_;                       // last: it uses the other members
};

}  // namespace takt::web
