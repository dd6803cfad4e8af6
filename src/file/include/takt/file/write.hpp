// A file written whole or not at all.
#pragma once

#include <string>
#include <string_view>

#include "takt/base/result.hpp"

namespace takt::file {

/// Writes a file beside its target and puts it there when it is safely on the disk: who reads `path` finds
/// the old contents or the new, never a part. A file that is there already stays, unless `replace`; then its
/// rights are kept, and a symbolic link goes on pointing to it.
///
/// Errors, with the path as their subject: cannot_open (operating system's number; EEXIST: it is there
/// already, EISDIR), unsupported (there, but not a regular file), io_failed (operating system's number).
[[nodiscard]] Result<void> write_file(const std::string& path, std::string_view bytes, bool replace);

}  // namespace takt::file
