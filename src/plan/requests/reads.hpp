// The reads of a device by function, as input of cover().
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "requests/boundary.hpp"
#include "requests/cover.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/learning.hpp"

namespace takt::plan {

/// A variable to read, or a piece of one that is longer than a request.
struct ReadItem {
    std::size_t variable = 0;  ///< index into the device's
    Duration period{};
    std::optional<Duration> deadline;  ///< see due_within()
    std::optional<model::LocalIndex> trigger;
    std::optional<model::LocalIndex> status;
};

/// The reads of one device with one function. Values longer than a request are cut into pieces of its limit,
/// the rest last. Other values are not cut.
struct FunctionReads {
    wire::Function function{};
    ItemLimit limit;
    RequestCost cost;             ///< see read_cost()
    std::vector<Span> spans;      ///< ordered by start, end, bit and name, not by the file
    std::vector<ReadItem> items;  ///< of each span
    /// Readable runs: the items of used variables of this function, of any period, and, unless `gaps`
    /// is `never`, the items in `readable`, not in `no_read`, and (`learn`) not refused.
    std::vector<Span> readable;

    [[nodiscard]] CoverRules rules() const;
};

/// A subset of a function's spans, ascending, with their indices.
struct Selection {
    std::vector<Span> spans;
    std::vector<std::size_t> items;
};

/// The reads of a device in strategy optimal, by function. Functions without reads are omitted.
[[nodiscard]] std::vector<FunctionReads> reads_of(const model::Project& project, const model::Line& line,
                                                  const model::Device& device);

}  // namespace takt::plan
