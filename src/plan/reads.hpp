// What is to be read of a device with one function, ready to be covered by requests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "boundary.hpp"
#include "cover.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/learning.hpp"

namespace takt::plan {

/// A variable that is read, or a piece of one that is longer than a request.
struct ReadItem {
    std::size_t variable = 0;  ///< index into the device's
    Duration period{};
    std::optional<Duration> deadline;  ///< see due_within()
    std::optional<model::LocalIndex> trigger;
    std::optional<model::LocalIndex> status;
};

/// The reads of one device with one function. Values longer than a request are cut into pieces of its limit,
/// the rest last; nothing else is cut.
struct FunctionReads {
    wire::Function function{};
    ItemLimit limit;
    RequestCost cost;             ///< see read_cost()
    std::vector<Span> spans;      ///< by start, end, bit and name: never by the order of the file
    std::vector<ReadItem> items;  ///< what lies in each span
    /// Runs of what may be read: where a used variable of this function lies, whatever its period, and,
    /// unless `gaps` is `never`, what is `readable`, not in `no_read`, and (`learn`) was not refused.
    std::vector<Span> readable;

    [[nodiscard]] CoverRules rules() const;
};

/// Some of a function's spans, ascending, each with its index there.
struct Selection {
    std::vector<Span> spans;
    std::vector<std::size_t> items;
};

/// The reads of a device in strategy optimal, by function; functions that read nothing are left out.
[[nodiscard]] std::vector<FunctionReads> reads_of(const model::Project& project, const model::Line& line,
                                                  const model::Device& device);

}  // namespace takt::plan
