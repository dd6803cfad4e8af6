// From a plan to its request table.
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
    /// Names, units and ports go along. A controller does without.
    bool names = true;
};

/// The plan and what of the project is needed to run it, in Takt's own format. The image passes View::open.
/// A time-out, a deadline, an order are in it as the poller would use them.
/// @returns too_long (bytes, kMaxImage); unsupported (subject: a device, or a variable) where a plan does not
///          keep what docs/formats/request-table.md asks of its entries
[[nodiscard]] Result<Image> build(const model::Project& project, const plan::Plan& plan,
                                  const BuildOptions& options);

/// Puts the length and the checksum into an image whose header has them at their places; shared by both
/// formats.
void seal(Image& image);

}  // namespace takt::table
