// Atomic writing of whole files.
#pragma once

#include <string>
#include <string_view>

#include "takt/base/result.hpp"

namespace takt::file {

/// Writes a temporary file next to the target, flushes it to the disk and renames it. Readers of `path` find
/// the old content or the new one, never a part. An existing file is an error unless `replace`; then its
/// permissions are kept, and a symbolic link still points to it.
///
/// Errors, with the path as their subject: cannot_open (operating system's number; EEXIST: it is there
/// already, EISDIR), unsupported (there, but not a regular file), io_failed (operating system's number).
[[nodiscard]] Result<void> write_file(const std::string& path, std::string_view bytes, bool replace);

}  // namespace takt::file
