// The limit of open descriptors.
#pragma once

#include <cstddef>

namespace takt::line {

/// Raises the soft limit of the process to its hard limit. Any thread.
/// @returns the new limit
[[nodiscard]] std::size_t raise_descriptor_limit();

}  // namespace takt::line
