// The marks of trends: what happened lately, as messages and commands with their outcomes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <vector>

#include "takt/file/json.hpp"
#include "takt/text/language.hpp"

namespace takt::web {

struct Mark {
    enum class Kind : std::uint8_t { message, command };

    std::int64_t time_ms = 0;  ///< since 1970
    Kind kind = Kind::message;
    std::string severity;      ///< "info", "warning" or "error"
    std::string outcome = {};  ///< of a command: outcome_word()
    std::string origin = {};   ///< likewise: the address of a browser; empty: another face
    std::array<std::string, text::kLanguages.size()> texts = {};

    friend bool operator==(const Mark&, const Mark&) = default;
};

/// The newest kMost messages and the newest kMost commands, in memory. Any thread.
class Marks {
public:
    static constexpr std::size_t kMost = 1000;

    /// @param since_ms  events before it are not known
    explicit Marks(std::int64_t since_ms) : since_ms_(since_ms) {}

    void put(Mark mark);

    /// Puts the marks of an earlier run, in their order, before all others. Called once.
    /// @param since_ms  of the earlier run
    void put_before(std::int64_t since_ms, std::vector<Mark> earlier);

    /// Marks in the order in which they were put.
    struct Part {
        std::vector<Mark> marks;
        std::int64_t last = kNone;  ///< number of the last one; kNone: there is none
        std::int64_t since_ms = 0;  ///< events before it are not kept
    };
    static constexpr std::int64_t kNone = INT64_MIN;

    /// The marks with numbers above `number`. Marks of an earlier run have negative numbers.
    [[nodiscard]] Part after(std::int64_t number) const;

    /// {"since","events":[{"time","kind","severity","text","outcome"?,"origin"?}…]} in order of time.
    /// [from_ms, to_ms); `since`: events before it are not kept.
    [[nodiscard]] file::Json json(text::Language language, std::int64_t from_ms, std::int64_t to_ms) const;

private:
    struct Entry {
        std::int64_t number = 0;
        Mark mark;
    };
    using List = std::deque<Entry>;

    [[nodiscard]] List& list_of(Mark::Kind kind) { return lists_[static_cast<std::size_t>(kind)]; }
    void trim(List& list);

    mutable std::mutex mutex_;  // of all below
    std::int64_t since_ms_;
    std::int64_t next_ = 0;
    std::array<List, 2> lists_;
};

}  // namespace takt::web
