// Strategy optimal: the requests of a device with the least bus time.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "cover_reason.hpp"
#include "reads.hpp"
#include "takt/plan/plan.hpp"

namespace takt::plan {

/// The entries of a device: those that read by function and start, then those that only write by function and
/// start. Device index, bus time and frame lengths are left to the caller, requests with the same stream
/// number share a stream.
///
/// All used variables that are read are polled with their period; those with a start-reading trigger are read
/// by entries of that trigger as well, which are one with a polled entry where that has the same items and
/// variables.
[[nodiscard]] std::vector<Request> optimal_requests(const model::Project& project, const model::Line& line,
                                                    const model::Device& device);

/// The polled requests of one function, by start: each period by itself. Streams are numbered from 0.
[[nodiscard]] std::vector<Request> polled_alone(const FunctionReads& reads, const CoverReasons& reasons);

/// A request with its variables, their common status and least deadline, and what it bridges; neither polled
/// nor triggered.
[[nodiscard]] Request read_request(const FunctionReads& reads, const CoverReasons& reasons,
                                   const Covered& covered);

/// The requests of least cost for some of a function's spans, with their reasons, by start; neither polled
/// nor triggered. Each lists all of the selected spans that it holds.
[[nodiscard]] std::vector<Request> covering_requests(const FunctionReads& reads, const CoverReasons& reasons,
                                                     const Selection& selection);

}  // namespace takt::plan
