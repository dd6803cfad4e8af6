// Which request is executed next: the threads are shared out by the kind of work and by visitor.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/web/api.hpp"

namespace takt::web {

/// A request that waits holds no thread. Of those that may start, one of the visitor with the fewest requests
/// in execution is next; among these the oldest. Not thread-safe.
class RequestQueue {
public:
    /// Of the requests in execution.
    struct Share {
        std::size_t all = 1;
        std::size_t visitor = 1;  ///< of one visitor
    };
    struct Limits {
        std::array<Share, kWorks.size()> executing;  ///< by Work
        std::size_t waiting = 64;
        std::size_t waiting_of_visitor = 16;
    };
    using Id = std::uint64_t;
    struct Entry {
        Id id = 0;
        Work work = Work::quick;
        std::string visitor;
        /// A newer entry with the same text ends it. Empty: none does.
        std::string superseded_by = {};
    };
    enum class Pushed : std::uint8_t {
        accepted,
        visitor_full,  ///< too many requests of the visitor wait
        full,          ///< too many requests wait
    };

    explicit RequestQueue(const Limits& limits) : limits_(limits) {}

    /// Appends a request whose id is in use nowhere. One that may start at once is always accepted.
    [[nodiscard]] Pushed push(Entry entry);
    /// The requests that the last one pushed supersedes.
    [[nodiscard]] std::vector<Id> superseded() const;
    /// It is to stop. If another one may supersede it, its handler has nothing left to do then, so it counts
    /// as quick from now on while it waits. Other ids are ignored.
    void cut_short(Id id);
    /// The request that starts now; nothing: none may.
    [[nodiscard]] std::optional<Id> next();
    /// It was executed, or its client has gone while it waited. An unknown id is ignored.
    void remove(Id id);

    [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }

private:
    struct Counts {
        std::array<std::size_t, kWorks.size()> of_work{};
        std::size_t all = 0;
    };

    [[nodiscard]] bool may_start(const Entry& entry) const;
    [[nodiscard]] const Counts& of(std::string_view visitor) const;
    void count(const Entry& entry, int change);

    Limits limits_;
    std::vector<Entry> waiting_;  // the oldest first
    std::vector<Entry> executing_;
    Counts counts_;
    std::map<std::string, Counts, std::less<>> visitors_;  // with requests in execution
    Entry last_;
};

}  // namespace takt::web
