// Timetables: how often each span of a neighbourhood is read, and which periods share requests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "requests/cover.hpp"
#include "timing/calendar.hpp"

namespace takt::plan {

/// A span that must be read at least once per period.
struct TimedSpan {
    Span items;
    Duration period{};  ///< above zero
    /// Must not be read more often: a piece of a value, useless without the others.
    bool fixed = false;
};

/// A cache of calendars.
class Calendars {
public:
    /// @returns nothing if a limit of Calendar is exceeded; valid as long as this object
    [[nodiscard]] const Calendar* of(std::span<const Duration> periods);

private:
    std::map<std::vector<Duration>, std::optional<Calendar>> calendars_;
};

/// Spans with the same period are read together. At instants when several periods of a block are due, all due
/// spans of the block are read together.
struct Timetable {
    std::vector<Duration> periods;  ///< of each span; at most its own
    /// The greatest period of each block, ascending. Blocks are consecutive in the order of the periods.
    std::vector<Duration> blocks;
    double utilization = 0;        ///< cost per nanosecond
    std::size_t progressions = 0;  ///< progressions in which it is read
};

/// A request of a timetable.
struct TimedWindow {
    Span items;
    Progression progression;
    /// The spans of its block that lie completely in it, ascending: the due ones, and those that are read in
    /// addition. Fixed spans only if they are due.
    std::vector<std::size_t> spans;
    /// The next request at the instants with the most due periods; nothing if it is the last one there.
    std::optional<Span> next;
};

/// A subset of a neighbourhood's spans. Bit i % 64 of word i / 64 is span i.
using SpanSet = std::vector<std::uint64_t>;

/// Compares timetables of spans that may share requests.
class Neighbourhood {
public:
    /// Each progression costs 1 / kProgressionsOfUtilization of the utilization with each period alone. So
    /// all progressions together (Calendar::kMostProgressions) cost less than one per cent.
    static constexpr double kProgressionsOfUtilization = 8192;

    /// Keeps references to `spans` and `calendars`.
    /// @param spans  by start, then end; not empty
    Neighbourhood(std::span<const TimedSpan> spans, const CoverRules& rules, Calendars& calendars);

    [[nodiscard]] std::span<const TimedSpan> spans() const { return spans_; }
    [[nodiscard]] const CoverRules& rules() const { return rules_; }
    [[nodiscard]] Calendars& calendars() const { return calendars_; }
    /// The timetable with the given periods, each planned alone.
    [[nodiscard]] const Timetable& alone() const { return alone_; }
    /// The best partition into blocks for these periods.
    [[nodiscard]] Timetable timetable(std::vector<Duration> periods);
    /// Whether `a` has the lower score: utilization plus the price of its progressions.
    [[nodiscard]] bool better(const Timetable& a, const Timetable& b) const;
    /// The requests of the timetable, ordered by items, then phase. At each instant at which a span is due,
    /// it lies completely in one request of its block.
    [[nodiscard]] std::vector<TimedWindow> requests(const Timetable& timetable) const;
    /// The items that are read when only the spans with that period are due.
    [[nodiscard]] std::vector<Span> read_with(const Timetable& timetable, Duration period) const;

private:
    struct Group {
        Duration period{};
        SpanSet members;
    };
    struct Worth {
        double utilization = 0;
        std::size_t progressions = 0;
    };

    [[nodiscard]] std::vector<Group> groups(const std::vector<Duration>& periods) const;
    [[nodiscard]] std::vector<Window> windows(const SpanSet& members) const;
    [[nodiscard]] static SpanSet due(std::span<const Group> block, std::uint32_t periods);
    [[nodiscard]] const Calendar* calendar(std::span<const Group> block) const;
    [[nodiscard]] std::optional<Worth> worth(std::span<const Group> block);
    void add_requests(std::span<const Group> block, std::vector<TimedWindow>& requests) const;
    [[nodiscard]] double cost(const SpanSet& members);
    [[nodiscard]] double score(double utilization, std::size_t progressions) const;

    std::span<const TimedSpan> spans_;
    CoverRules rules_;
    Calendars& calendars_;
    std::map<SpanSet, double> costs_;
    double progression_price_ = 0;
    Timetable alone_;
};

}  // namespace takt::plan
