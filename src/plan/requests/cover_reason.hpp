// Reasons of a minimum-cost cover: the ends of requests, and the saving by reading gaps.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>

#include "requests/reads.hpp"

namespace takt::plan {

/// A request with the spans of its function that it reads.
struct Covered {
    Span items;
    std::span<const std::size_t> members;  ///< ascending, not empty
};

/// Gives the reasons for requests of one function of one device.
class CoverReasons {
public:
    CoverReasons(const model::Line& line, const model::Device& device, const FunctionReads& reads);

    /// Why two consecutive requests of an optimal cover are not one.
    [[nodiscard]] Reason apart(const Covered& here, const Covered& next) const;
    /// The next span has another period and is not due at the same instants as `here`.
    [[nodiscard]] Reason other_period(const Covered& here, std::size_t next) const;
    /// No request follows.
    [[nodiscard]] Reason last(const Covered& here) const;
    /// The saving by reads of the gaps between the members; nothing if there are none.
    [[nodiscard]] std::optional<Reason> bridged(const Covered& here) const;

private:
    [[nodiscard]] const model::Variable& variable(std::size_t item) const;
    [[nodiscard]] std::size_t last_of(const Covered& here) const;
    /// The first member of `next` that is not in `here`.
    [[nodiscard]] std::size_t first_beyond(const Covered& here, const Covered& next) const;
    [[nodiscard]] std::optional<std::string> forbidden_by(const Span& gap) const;
    /// Two different costs in milliseconds, the greater one first, with enough digits to distinguish them.
    [[nodiscard]] std::pair<std::string, std::string> milliseconds(ExactTime a, ExactTime b) const;

    const model::Device& device_;
    const FunctionReads& reads_;
    double units_per_ms_;
};

}  // namespace takt::plan
