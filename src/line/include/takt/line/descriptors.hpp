// How many files and connections the program may have open.
#pragma once

#include <cstddef>

namespace takt::line {

/// Raises the soft limit of the process to its hard limit. Any thread.
/// @returns how many descriptors it may have open
[[nodiscard]] std::size_t raise_descriptor_limit();

}  // namespace takt::line
