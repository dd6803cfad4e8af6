// Builds the request table of a plan.
#pragma once

#include <cstdint>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"

namespace takt::table {

using Image = std::vector<std::uint8_t>;

struct BuildOptions {
    /// Settings of the bus of each line of the project, as the poller has them.
    std::vector<bus::LineConfig> lines;
    /// Whether names, units and ports are included. A controller does not need them.
    bool names = true;
};

/// The plan, and the part of the project that is needed to run it, in Takt's own format. The image passes
/// View::open. Time-outs, deadlines and orders are those that the poller would use.
/// @returns too_long (bytes, kMaxImage); unsupported (subject: a device, or a variable) if the plan has an
///          entry that docs/formats/request-table.md does not allow, or uses a service variable
[[nodiscard]] Result<Image> build(const model::Project& project, const plan::Plan& plan,
                                  const BuildOptions& options);

}  // namespace takt::table
