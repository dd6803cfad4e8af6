// Damaged files are kept under another name.
#pragma once

#include <string>

#include "takt/base/result.hpp"

namespace takt::os {

/// Renames a damaged file to the first free of PATH.damaged-1 to -999, together with the file PATH +
/// `companion`, which may hold a part of it.
/// @returns the new path; io_failed; queue_full: none is free
[[nodiscard]] Result<std::string> set_aside(const std::string& path, const std::string& companion = {});

}  // namespace takt::os
