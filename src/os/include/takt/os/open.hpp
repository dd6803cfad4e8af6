// Opening regular files by a path that a user gave.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <string>
#include <string_view>

#include "takt/base/result.hpp"
#include "takt/os/descriptor.hpp"

namespace takt::os {

/// Mode of a state or log file that the program creates: group may read, others may not.
constexpr ::mode_t kStateFileMode = 0640;

// The functions below open regular files only, unless they say otherwise, and never wait. A FIFO, a device or
// a socket is rejected before it is opened, because opening one may block or change the lines of a serial
// port. Descriptors are close-on-exec.
//
// Errors, with the path as subject: cannot_open (the system's error number; EISDIR for a folder), unsupported
// (not a regular file).
//
// A file that is appended to or made empty is not opened through a symbolic link (ELOOP): another user may
// have created the link. The links of the system are followed, and links to them: /dev/NAME, /dev/fd/N,
// /dev/pts/N, /proc/self/fd/N.

/// Opens an existing file for reading.
[[nodiscard]] Result<Descriptor> open_for_reading(const std::string& path);

/// Opens an existing file or FIFO for reading. A FIFO need not have a writer yet: poll() waits for one. With
/// one that has written nothing, read() fails with EAGAIN.
[[nodiscard]] Result<Descriptor> open_stream(const std::string& path);

/// Opens an existing file for reading and writing.
[[nodiscard]] Result<Descriptor> open_for_update(const std::string& path);

/// Opens a file for appending, and creates it with `mode` (less the umask) where there is none.
[[nodiscard]] Result<Descriptor> open_for_append(const std::string& path, ::mode_t mode = kStateFileMode);

/// Makes a file empty and opens it for appending. It is created with `mode` (less the umask) where there is
/// none. One program at a time has it: it is locked (flock, exclusive) before it is made empty, for as long
/// as the descriptor or a duplicate is open. A file system without locks does without. An existing FIFO,
/// terminal or device is opened as it is.
/// @returns cannot_open, also for a FIFO without a reader; busy (path): another program has it; io_failed
[[nodiscard]] Result<Descriptor> open_anew(const std::string& path, ::mode_t mode = kStateFileMode);

/// Creates a file for reading and writing with `mode` (less the umask).
/// @returns cannot_open with EEXIST where the path exists, also as a link that leads nowhere
[[nodiscard]] Result<Descriptor> create_file(const std::string& path, ::mode_t mode = kStateFileMode);

/// Whether the path, with links followed, still leads to the open file.
[[nodiscard]] bool is_at(int descriptor, const std::string& path);

/// Reads from the descriptor's position to the end of the file. The size of a file is no bound: it may grow,
/// and files of /proc have none.
/// @param path  the subject of an error
/// @returns io_failed (system's error number), too_long (bytes read, bytes allowed)
[[nodiscard]] Result<std::string> read_all(int descriptor, const std::string& path, std::size_t limit);

/// Writes all of `bytes` at the descriptor's position. @returns false with errno set; a part may be written
[[nodiscard]] bool write_all(int descriptor, std::string_view bytes);

}  // namespace takt::os
