// Which of several periods are due at the same instants. All of them start at instant 0.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "takt/base/time.hpp"

namespace takt::plan {

/// The least common multiple of two periods above zero; nothing if it exceeds `most`.
[[nodiscard]] std::optional<std::int64_t> common_multiple(std::int64_t a, std::int64_t b, std::int64_t most);

/// The instants phase + n * period, n = 0, 1, …; phase < period.
struct Progression {
    Duration period{};
    Duration phase{};
    friend bool operator==(const Progression&, const Progression&) = default;
};

/// Divides the instants of a hyperperiod by their due set, the set of the periods that are due at an instant.
class Calendar {
public:
    /// Longest hyperperiod, in units of the periods' greatest common divisor.
    static constexpr std::size_t kMostTicks = 4096;
    /// Limit of the progressions of all due sets together.
    static constexpr std::size_t kMostProgressions = 64;
    static constexpr std::size_t kMostPeriods = 16;

    struct DueSet {
        std::uint32_t periods = 0;  ///< bit i: the i-th period is due
        std::size_t ticks = 0;      ///< instants in a hyperperiod
    };

    /// @param periods  ascending, distinct, above zero, at least one
    /// @returns nothing if a limit is exceeded
    [[nodiscard]] static std::optional<Calendar> of(std::span<const Duration> periods);

    /// The due sets that are not empty, ordered by `periods`; at most kMostProgressions.
    [[nodiscard]] std::span<const DueSet> due_sets() const { return due_sets_; }
    [[nodiscard]] Duration hyperperiod() const { return tick_ * static_cast<std::int64_t>(tick_count_); }
    /// The sum of the progressions of every single due set.
    [[nodiscard]] std::size_t progression_count() const { return progression_count_; }

    /// The instants of several due sets as disjoint progressions, ordered by phase. Each one starts at the
    /// earliest instant left. Its period is the shortest divisor of the hyperperiod for which every instant
    /// of the progression belongs to the sets.
    /// @param sets  bit i: of the i-th due set
    [[nodiscard]] std::vector<Progression> progressions(std::uint64_t sets) const;

private:
    void mark(std::span<const Duration> periods);
    void divide(std::size_t ticks);
    [[nodiscard]] std::vector<bool> due(std::uint64_t sets) const;

    Duration tick_{};
    std::size_t tick_count_ = 0;
    std::vector<std::size_t> divisors_;  // of tick_count_, ascending
    std::vector<DueSet> due_sets_;
    std::vector<std::uint8_t> set_at_;  // for each tick the index of its due set; kNothingDue: none
    std::size_t progression_count_ = 0;
};

}  // namespace takt::plan
