// A full file gets a number, and an empty file takes its name.
#pragma once

#include <functional>
#include <string>

#include "takt/base/result.hpp"
#include "takt/os/descriptor.hpp"

namespace takt::os {

/// The name of the file with that number. 0: the current one; 1: the one before it.
using NumberedName = std::function<std::string(unsigned number)>;

/// Puts an empty file in the place of a full one, which gets the number 1. Older ones are renumbered up to
/// the first free number; without one, the file with the number `old_files` is removed. Where the name leads
/// to no file any more, the empty file is created only.
///
/// The empty file is opened and locked by open_anew() before it takes the name: another program never finds
/// the name free. A file system that cannot exchange two names (NFS) leaves a moment in which it is.
/// @param current    the full file, of open_anew()
/// @param old_files  0: the full file is made empty
/// @returns replaced (another file has the name), io_failed (path, system's error number), as open_anew();
///          then the full file can still be written
[[nodiscard]] Result<Descriptor> begin_next_file(int current, unsigned old_files, const NumberedName& name);

}  // namespace takt::os
