// The write entries of a device, and how they join its reads (strategy optimal; bits of registers for all).
#pragma once

#include <vector>

#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"

namespace takt::plan {

/// The fewest requests that write what is written on change or by a trigger, each value once: grouped where
/// adjacent and due together (start-writing trigger, write on change, admission), as far as the device's
/// `write_single` allows; where variables overlap, perhaps one more. No item is touched that nobody asked to
/// write, no value is split, overlapping variables never share a request. Bits of one register that are due
/// together are one 0x16, or one read-modify-write; where the device has neither they are not written.
/// @returns by function and start, with reason and admission; the device index and costs are left to the
/// caller. Independent of the order of the variables; O(n log n).
[[nodiscard]] std::vector<Request> write_requests(const model::Project& project, const model::Line& line,
                                                  const model::Device& device);

/// The bools in registers, each by itself: what strategy classic leaves out.
[[nodiscard]] std::vector<Request> bit_write_requests(const model::Project& project,
                                                      const model::Device& device);

/// How a bool in a register is written: 0x16, or `read_modify_write` with 0x06 or 0x10. Nothing is changed
/// where the device allows neither, or the request writes something else.
void settle_bit_write(Request& request, const model::Device& device);

/// Puts reads and writes together. With `fc23` a read by a trigger and a write by the same trigger become one
/// 0x17; what such a read also polls goes on as an entry of its own. Then a write of exactly the variables of
/// a read joins it.
/// @param reads   by function and start
/// @param writes  of write_requests()
/// @returns those that read by function and start, then those that only write
[[nodiscard]] std::vector<Request> joined(const model::Project& project, const model::Line& line,
                                          const model::Device& device, std::vector<Request> reads,
                                          std::vector<Request> writes);

}  // namespace takt::plan
