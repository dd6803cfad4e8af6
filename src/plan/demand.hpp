// The demand of tasks on a line: sums over releases (docs/guarantees.md, "Model").
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "takt/plan/response.hpp"

namespace takt::plan {

/// Holds every product and sum of times without overflow.
__extension__ typedef __int128 WideTime;

/// The demand of n consecutive releases of one task, in the costliest case.
class Demand {
public:
    explicit Demand(const Task& task);
    /// Jobs of one shape: so many frames of equal length.
    Demand(Microseconds frame, std::uint32_t frames);

    [[nodiscard]] WideTime most(std::int64_t jobs) const;
    [[nodiscard]] Microseconds longest_frame() const { return longest_frame_; }
    [[nodiscard]] bool cyclic() const { return totals_.size() > 1; }
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
    void add_shape(const std::vector<Microseconds>& frames);
    [[nodiscard]] std::int64_t shapes() const { return static_cast<std::int64_t>(totals_.size()); }
    [[nodiscard]] WideTime ending_at(std::size_t shape, std::int64_t jobs) const;

    std::vector<WideTime> totals_;     // of each shape
    std::vector<WideTime> sums_{0};    // of the shapes before each
    std::vector<Microseconds> lasts_;  // last frame of each shape, 0: it sends nothing
    Microseconds longest_frame_ = 0;
    mutable std::vector<WideTime> most_;  // of less than a cycle, once asked for; else -1
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

/// The sum of the demands of a set of tasks. Tasks of one shape with the same arrivals are one term.
class Interference {
public:
    explicit Interference(const Failures& failures) : failures_(&failures) {}

    /// @param demand  must outlive this
    void add(const Arrivals& arrivals, const Demand& demand);

    [[nodiscard]] WideTime closed(Microseconds t) const;
    [[nodiscard]] WideTime half_open(Microseconds t) const;
    /// What a step costs.
    [[nodiscard]] std::size_t terms() const { return terms_.size() + cyclic_.size() + 1; }
    /// rate * t + least <= closed(t) <= rate * t + most.
    [[nodiscard]] double rate() const { return rate_; }
    [[nodiscard]] double most() const { return most_; }
    [[nodiscard]] double least() const { return least_; }
    [[nodiscard]] double least_rate() const { return least_rate_; }

private:
    struct Term {
        Arrivals arrivals;  // burst 0: the burst is part of `at_once`
        WideTime at_once = 0;
        WideTime each = 0;
    };
    struct Cyclic {
        Arrivals arrivals;
        const Demand* demand;
    };
    Term& term_of(const Arrivals& arrivals);
    [[nodiscard]] WideTime sum(Microseconds t, Microseconds open) const;

    const Failures* failures_;
    std::map<std::tuple<Microseconds, Microseconds, Microseconds>, std::size_t> index_;  // of the later terms
    std::vector<Term> terms_;
    std::vector<Cyclic> cyclic_;
    double rate_ = 0;
    double least_rate_ = 0;
    double most_ = 0;
    double least_ = 0;
};

}  // namespace takt::plan
