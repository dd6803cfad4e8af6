// The demand of tasks on a line: sums over releases (docs/guarantees.md, "Model").
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "takt/plan/response.hpp"

namespace takt::plan {

/// Holds every product and sum of times without overflow.
__extension__ typedef __int128 WideTime;

/// Exceeds the rounding error of sums of rates.
inline constexpr double kRateRounding = 1e-9;

/// Task::device of a task that belongs to no device: it never dies.
inline constexpr std::uint32_t kNoDevice = UINT32_MAX;

/// The demand of n consecutive releases of one task, in the costliest case.
class Demand {
public:
    explicit Demand(const Task& task);
    /// Jobs of one shape: so many frames of equal length.
    Demand(Microseconds frame, std::uint32_t frames);

    [[nodiscard]] WideTime most(std::int64_t jobs) const {
        return cycle_ ? cycle_->most(jobs) : total_ * jobs;
    }
    [[nodiscard]] Microseconds longest_frame() const { return longest_frame_; }
    [[nodiscard]] bool cyclic() const { return cycle_ != nullptr; }
    [[nodiscard]] double mean() const;   ///< of one job
    [[nodiscard]] double slack() const;  ///< most(n) <= n * mean + slack

    /// A possible end of n jobs: the demand before the last frame, and the last frame. endings() leaves out
    /// pairs that another pair dominates.
    struct Ending {
        WideTime before = 0;
        Microseconds last = 0;
    };
    void endings(std::int64_t jobs, std::vector<Ending>& to) const;

private:
    /// Two or more shapes.
    struct Cycle {
        std::vector<WideTime> totals;               // of each shape
        std::vector<WideTime> sums{0};              // of the shapes before each
        std::vector<Microseconds> lasts;            // last frame of each shape, 0: it sends nothing
        mutable std::vector<WideTime> most_of_few;  // of less than a cycle, once asked for; else -1

        explicit Cycle(const std::vector<std::vector<Microseconds>>& shapes);
        [[nodiscard]] std::int64_t shapes() const { return static_cast<std::int64_t>(totals.size()); }
        [[nodiscard]] WideTime ending_at(std::size_t shape, std::int64_t jobs) const;
        [[nodiscard]] WideTime most(std::int64_t jobs) const;
    };

    WideTime total_ = 0;  // of all shapes
    Microseconds longest_frame_ = 0;
    Microseconds last_ = 0;  // last frame of the only shape
    std::unique_ptr<const Cycle> cycle_;
};

/// The release pattern of a task.
struct Arrivals {
    Microseconds period = 0;
    Microseconds jitter = 0;
    Microseconds late = 0;  ///< of failures
    std::uint32_t burst = 1;

    /// Releases in a closed window t.
    [[nodiscard]] std::int64_t closed(Microseconds t) const { return burst + (t + jitter) / period; }
    /// Releases in a half-open window t > 0 of whole ticks.
    [[nodiscard]] std::int64_t half_open(Microseconds t) const { return burst + (t + jitter - 1) / period; }
};

/// E(t), the number of failures in a window t, under the project's fault rate.
class Failures {
public:
    Failures() = default;
    /// @param spared  number of failures that the caller counts separately
    Failures(const FaultRate& rate, std::uint32_t spared) : rate_(rate), spared_(spared) {}

    [[nodiscard]] std::int64_t within(Microseconds t) const {
        if (!rate_) return 0;
        const std::int64_t all = rate_->burst + t / rate_->every;
        return all > spared_ ? all - spared_ : 0;
    }
    /// within(t) <= most_at_once + rate * t.
    [[nodiscard]] double rate() const { return rate_ ? 1.0 / static_cast<double>(rate_->every) : 0; }
    [[nodiscard]] double most_at_once() const { return rate_ ? rate_->burst : 0; }

private:
    std::optional<FaultRate> rate_;
    std::uint32_t spared_ = 0;
};

/// Divides by the same number again and again, exactly. A product with the inverse, which is off by one at
/// most, is faster than a division.
class Divisor {
public:
    explicit Divisor(std::int64_t number) : number_(number), inverse_(1.0 / static_cast<double>(number)) {}

    /// @param dividend  at least 0
    [[nodiscard]] std::int64_t divide(std::int64_t dividend) const {
        if (dividend >= kExact) return dividend / number_;
        auto quotient = static_cast<std::int64_t>(static_cast<double>(dividend) * inverse_);
        const std::int64_t rest = dividend - quotient * number_;
        quotient -= rest < 0 ? 1 : 0;
        quotient += rest >= number_ ? 1 : 0;
        return quotient;
    }

private:
    static constexpr std::int64_t kExact = std::int64_t{1}
                                           << 51;  // a double holds such numbers and their halves

    std::int64_t number_;
    double inverse_;
};

/// The sum of the demands of a set of tasks. Tasks of one shape with the same arrivals are one term.
class Interference {
public:
    explicit Interference(const Failures& failures) : failures_(&failures) {}

    /// Without tasks again.
    void clear();
    /// @param demand  must outlive this
    void add(const Arrivals& arrivals, const Demand& demand);

    [[nodiscard]] WideTime closed(Microseconds t) const;
    [[nodiscard]] WideTime half_open(Microseconds t) const;
    /// The cost of a step.
    [[nodiscard]] std::size_t terms() const { return terms_.size() + cyclic_.size() + 1; }
    /// rate * t + least <= closed(t) <= rate * t + most.
    [[nodiscard]] double rate() const { return rate_; }
    [[nodiscard]] double most() const { return most_; }
    [[nodiscard]] double least() const { return least_; }
    [[nodiscard]] double least_rate() const { return least_rate_; }

private:
    struct Term {
        Divisor period;
        Microseconds jitter = 0;
        WideTime each = 0;
        Arrivals arrivals;
    };
    struct Hash {
        std::size_t operator()(const Arrivals& arrivals) const;
    };
    struct SameTerm {
        bool operator()(const Arrivals& a, const Arrivals& b) const {
            return a.period == b.period && a.jitter == b.jitter && a.late == b.late;
        }
    };
    struct Cyclic {
        Arrivals arrivals;
        const Demand* demand;
    };
    Term& term_of(const Arrivals& arrivals);
    [[nodiscard]] WideTime sum(Microseconds t, Microseconds open) const;

    const Failures* failures_;
    std::unordered_map<Arrivals, std::size_t, Hash, SameTerm> index_;  // of the later terms
    std::vector<Term> terms_;
    WideTime at_once_ = 0;  // the bursts of all terms
    std::vector<Cyclic> cyclic_;
    double rate_ = 0;
    double least_rate_ = 0;
    double most_ = 0;
    double least_ = 0;
};

}  // namespace takt::plan
