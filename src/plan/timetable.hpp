// How often each span of a neighbourhood is read, and which of these periods share their requests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "calendar.hpp"
#include "cover.hpp"

namespace takt::plan {

/// A span that is to be read once in each period at least.
struct TimedSpan {
    Span items;
    Duration period{};  ///< above zero
    /// Not to be read more often: a piece of a value, of no use without the others.
    bool fixed = false;
};

/// Calendars made so far.
class Calendars {
public:
    /// @returns nothing where a limit of Calendar is exceeded; valid as long as this object
    [[nodiscard]] const Calendar* of(std::span<const Duration> periods);

private:
    std::map<std::vector<Duration>, std::optional<Calendar>> calendars_;
};

/// Spans are read together where they have the same period, and, at the instants at which several periods
/// of a block are due, all that is due in the block.
struct Timetable {
    std::vector<Duration> periods;  ///< of each span; at most its own
    /// The greatest period of each block, ascending; blocks are neighbours in the order of the periods.
    std::vector<Duration> blocks;
    double utilization = 0;  ///< cost per nanosecond
    std::size_t turns = 0;   ///< in how many turns of due sets it is read
};

/// A request of a timetable.
struct TimedWindow {
    Span items;
    Turn turn;
    /// Spans of its block that lie in it whole, ascending: those that are due, and those read besides. Fixed
    /// ones only where they are due.
    std::vector<std::size_t> spans;
    /// The request behind it where the most is due of its block; nothing where it is the last one there.
    std::optional<Span> next;
};

/// Some spans of a neighbourhood. Bit i % 64 of word i / 64: span i.
using SpanSet = std::vector<std::uint64_t>;

/// Weighs the timetables of spans that may share requests.
class Neighbourhood {
public:
    /// What a turn has to save: that part of the utilization with each period alone. So all turns there may
    /// be (Calendar::kMostTurns) are worth less than one per cent.
    static constexpr double kTurnsOfUtilization = 8192;

    /// Keeps references to `spans` and `calendars`.
    /// @param spans  by start, then end; not empty
    Neighbourhood(std::span<const TimedSpan> spans, const CoverRules& rules, Calendars& calendars);

    [[nodiscard]] std::span<const TimedSpan> spans() const { return spans_; }
    [[nodiscard]] const CoverRules& rules() const { return rules_; }
    [[nodiscard]] Calendars& calendars() const { return calendars_; }
    /// With its own periods, each planned alone.
    [[nodiscard]] const Timetable& alone() const { return alone_; }
    /// The best partition into blocks of spans with such periods.
    [[nodiscard]] Timetable timetable(std::vector<Duration> periods);
    /// Whether `a` is worth more than `b`: utilization, and the price of turns.
    [[nodiscard]] bool better(const Timetable& a, const Timetable& b) const;
    /// Its requests, by items, then phase. Within a block each span lies whole in one of those of each
    /// instant at which it is due.
    [[nodiscard]] std::vector<TimedWindow> requests(const Timetable& timetable) const;
    /// Where spans are read that have that period in the table and are due without others.
    [[nodiscard]] std::vector<Span> read_with(const Timetable& timetable, Duration period) const;

private:
    struct Group {
        Duration period{};
        SpanSet members;
    };
    struct Worth {
        double utilization = 0;
        std::size_t turns = 0;
    };

    [[nodiscard]] std::vector<Group> groups(const std::vector<Duration>& periods) const;
    [[nodiscard]] std::vector<Window> windows(const SpanSet& members) const;
    [[nodiscard]] static SpanSet due(std::span<const Group> block, std::uint32_t periods);
    [[nodiscard]] const Calendar* calendar(std::span<const Group> block) const;
    [[nodiscard]] std::optional<Worth> worth(std::span<const Group> block);
    void add_requests(std::span<const Group> block, std::vector<TimedWindow>& requests) const;
    [[nodiscard]] double cost(const SpanSet& members);
    [[nodiscard]] double score(double utilization, std::size_t turns) const;

    std::span<const TimedSpan> spans_;
    CoverRules rules_;
    Calendars& calendars_;
    std::map<SpanSet, double> costs_;
    double turn_price_ = 0;
    Timetable alone_;
};

}  // namespace takt::plan
