// What happened lately: messages, and commands with their outcomes. Trends show them as marks.
#pragma once

#include <array>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "takt/file/json.hpp"
#include "takt/report/texts.hpp"
#include "takt/web/host_access.hpp"

namespace takt::web {

/// Keeps the newest kMost messages and the newest kMost commands since the program started, in memory.
/// Commands of browsers come from the API. A thread of its own reads the events of the host: messages, writes
/// of other faces to devices, and `set` commands of theirs that failed. The host has no event for a `set`
/// that succeeded.
class EventLog {
public:
    static constexpr std::size_t kMost = 1000;
    static constexpr int kMostMessages = 20;  // in a tick; a flood of messages must not bury the others
    static constexpr auto kTick = std::chrono::milliseconds(250);

    explicit EventLog(HostAccess host);
    /// Ends the thread. A second call does nothing.
    void end();
    /// end()
    ~EventLog();
    EventLog(const EventLog&) = delete;
    EventLog& operator=(const EventLog&) = delete;

    /// The API reports the commands of this session itself. Called before its first command. Any thread.
    void own(host::SessionId session);
    /// A command of a browser. Any thread.
    void add(const host::Outcome& outcome, const host::Configuration& configuration, std::string address);

    /// {"since","events":[{"time","kind","severity","text","outcome"?,"origin"?}…]} in order of time.
    /// [from_ms, to_ms); `since`: events before it are not kept.
    [[nodiscard]] file::Json events(text::Language language, std::int64_t from_ms, std::int64_t to_ms) const;

private:
    struct Entry {
        std::int64_t time_ms = 0;
        std::string_view kind;
        std::string_view severity;
        std::string_view outcome;  // of a command
        std::string origin;        // likewise: the address of a browser; empty: another face
        std::array<std::string, text::kLanguages.size()> texts;
    };
    void work();
    void read_events();
    void add(const host::Event& event);
    void add_command(const host::Outcome& outcome, const host::Configuration& configuration,
                     std::string origin);
    [[nodiscard]] bool is_own(host::SessionId session) const;
    void put(std::deque<Entry>& list, Entry entry);

    HostAccess host_;
    std::unique_ptr<host::Session> session_;  // of the thread
    std::uint64_t missed_ = 0;                // likewise
    int messages_ = 0;                        // of this tick, likewise
    mutable std::mutex mutex_;                // of all below
    std::condition_variable changed_;
    bool ended_ = false;
    std::int64_t since_ms_ = 0;
    std::deque<Entry> commands_;
    std::deque<Entry> notices_;
    std::deque<host::SessionId> own_;  // the newest ones
    std::thread thread_;
};

}  // namespace takt::web
