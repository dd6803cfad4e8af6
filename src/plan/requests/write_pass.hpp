// The write requests of a device and their merging with reads (strategy optimal; bits of registers for all).
#pragma once

#include <vector>

#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"

namespace takt::plan {

/// The fewest requests that write each value once, on change or by a trigger. Adjacent values with equal
/// causes (start-writing trigger, write on change, rate limit) are grouped, as far as the device's
/// `write_single` allows. With overlapping variables there may be one request more. Only requested items are
/// written, no value is split, and overlapping variables never share a request. Bits of one register with
/// equal causes form one 0x16 or one read-modify-write; if the device has neither, they are not written.
/// @returns ordered by function and start, with reason and rate limit; the caller sets device index and
///          costs. Independent of the order of the variables; O(n log n)
[[nodiscard]] std::vector<Request> write_requests(const model::Project& project, const model::Line& line,
                                                  const model::Device& device);

/// The bools in registers, each one alone: classic omits them.
[[nodiscard]] std::vector<Request> bit_write_requests(const model::Project& project,
                                                      const model::Device& device);

/// Sets how a bool in a register is written: 0x16, or `read_modify_write` with 0x06 or 0x10. No change if the
/// device allows neither, or the request writes something else.
void settle_bit_write(Request& request, const model::Device& device);

/// Merges reads and writes. With `fc23` a read and a write by the same trigger become one 0x17; the variables
/// that such a read also polls get a request of their own. Then a write of exactly the variables of a read
/// joins it.
/// @param reads  ordered by function and start
/// @param writes  of write_requests()
/// @returns the requests that read, ordered by function and start, then those that only write
[[nodiscard]] std::vector<Request> joined(const model::Project& project, const model::Line& line,
                                          const model::Device& device, std::vector<Request> reads,
                                          std::vector<Request> writes);

}  // namespace takt::plan
