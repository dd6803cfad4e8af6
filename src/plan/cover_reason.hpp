// Why requests of least cost end where they end, and what reading gaps saves.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>

#include "reads.hpp"

namespace takt::plan {

/// A request, and the spans of its function that are read with it.
struct Covered {
    Span items;
    std::span<const std::size_t> members;  ///< ascending, not empty
};

/// Tells about the requests that read one function of one device.
class CoverReasons {
public:
    CoverReasons(const model::Line& line, const model::Device& device, const FunctionReads& reads);

    /// Why two requests that follow each other in an optimal cover are two.
    [[nodiscard]] Reason apart(const Covered& here, const Covered& next) const;
    /// Before a span of another period, which is not due when `here` is.
    [[nodiscard]] Reason other_period(const Covered& here, std::size_t next) const;
    /// No request follows.
    [[nodiscard]] Reason last(const Covered& here) const;
    /// What reading the gaps between the members saves; nothing where there are none.
    [[nodiscard]] std::optional<Reason> bridged(const Covered& here) const;

private:
    [[nodiscard]] const model::Variable& variable(std::size_t item) const;
    [[nodiscard]] std::size_t last_of(const Covered& here) const;
    /// The first member of `next` that `here` does not hold.
    [[nodiscard]] std::size_t first_beyond(const Covered& here, const Covered& next) const;
    [[nodiscard]] std::optional<std::string> forbidden_by(const Span& gap) const;
    /// Two different costs as milliseconds, the greater one first, with digits enough to tell them apart.
    [[nodiscard]] std::pair<std::string, std::string> milliseconds(ExactTime a, ExactTime b) const;

    const model::Device& device_;
    const FunctionReads& reads_;
    double units_per_ms_;
};

}  // namespace takt::plan
