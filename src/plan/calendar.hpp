// Which of several periods are due together, when all of them begin at the same instant.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "takt/base/time.hpp"

namespace takt::plan {

/// Due at phase + n * period, n = 0, 1, …; phase < period.
struct Turn {
    Duration period{};
    Duration phase{};
    friend bool operator==(const Turn&, const Turn&) = default;
};

/// Of n instants, those of each due set: the set of the periods that are due there.
class Calendar {
public:
    /// Longest hyperperiod, in units of the periods' greatest common divisor.
    static constexpr std::size_t kMostTicks = 4096;
    /// Most turns all due sets take together.
    static constexpr std::size_t kMostTurns = 64;
    static constexpr std::size_t kMostPeriods = 16;

    struct DueSet {
        std::uint32_t periods = 0;  ///< bit i: the i-th period is due
        std::size_t ticks = 0;      ///< instants in a hyperperiod
    };

    /// @param periods  ascending, distinct, above zero, at least one
    /// @returns nothing where one of the limits is exceeded
    [[nodiscard]] static std::optional<Calendar> of(std::span<const Duration> periods);

    /// Those that are not empty, by `periods`; at most kMostTurns.
    [[nodiscard]] std::span<const DueSet> due_sets() const { return due_sets_; }
    [[nodiscard]] Duration hyperperiod() const { return tick_ * static_cast<std::int64_t>(tick_count_); }
    /// Turns of all due sets together, each taken by itself.
    [[nodiscard]] std::size_t turn_count() const { return turn_count_; }

    /// The instants of several due sets as turns without an instant in common, by phase. Each in turn begins
    /// with the earliest instant left and has the shortest period, a divisor of the hyperperiod, of which no
    /// instant lies outside.
    /// @param sets  bit i: of the i-th due set
    [[nodiscard]] std::vector<Turn> turns(std::uint64_t sets) const;

private:
    void mark(std::span<const Duration> periods);
    void divide(std::size_t ticks);
    [[nodiscard]] std::vector<bool> due(std::uint64_t sets) const;

    Duration tick_{};
    std::size_t tick_count_ = 0;
    std::vector<std::size_t> divisors_;  // of tick_count_, ascending
    std::vector<DueSet> due_sets_;
    std::vector<std::uint8_t> set_at_;  // for each tick the index of its due set; kNothingDue: none
    std::size_t turn_count_ = 0;
};

}  // namespace takt::plan
