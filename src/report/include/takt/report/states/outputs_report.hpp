// The states of a project's outputs, as text and as JSON.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "takt/file/json.hpp"
#include "takt/publish/output_status.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// One line, without line end: state, destination, what waits and since when, what was lost, the last error.
/// @param wall_ns  now, ns since 1970 UTC
[[nodiscard]] std::string output_text(const Texts& texts, const publish::OutputStatus& status,
                                      std::int64_t wall_ns);
/// A line for each output; empty without outputs.
[[nodiscard]] std::string outputs_text(const Texts& texts, std::span<const publish::OutputStatus> outputs,
                                       std::int64_t wall_ns);

/// The same lines, of the key `outputs` of an object: outputs_json().
[[nodiscard]] std::string outputs_text(const Texts& texts, const file::Json& object);

/// docs/commands/run.md describes the keys.
[[nodiscard]] file::Json output_json(const Texts& texts, const publish::OutputStatus& status,
                                     std::int64_t wall_ns);
[[nodiscard]] file::Json outputs_json(const Texts& texts, std::span<const publish::OutputStatus> outputs,
                                      std::int64_t wall_ns);

/// Adds the key `outputs` to the answer to `status`. Its health is not `ok` where an output loses samples,
/// falls behind, cannot write its journal, or needs a person.
void add_outputs(const Texts& texts, file::Json& status, std::span<const publish::OutputStatus> outputs,
                 std::int64_t wall_ns);

}  // namespace takt::report
