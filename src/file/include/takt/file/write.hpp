// Writing a user's file atomically.
#pragma once

#include <string>
#include <string_view>

#include "takt/base/result.hpp"

namespace takt::file {

/// Writes a project, a table or another file of the user atomically (os::FileReplacement): a reader of `path`
/// finds the old contents or the new, never a part. An existing file is replaced only with `replace`; it
/// keeps its mode, and a symbolic link goes on pointing to it.
///
/// Errors, with the path as their subject: cannot_open (system's error number; EEXIST: the file exists,
/// EISDIR), unsupported (not a regular file), io_failed (system's error number).
[[nodiscard]] Result<void> write_file(const std::string& path, std::string_view bytes, bool replace);

}  // namespace takt::file
