// Reads a whole file within limits.
#pragma once

#include <cstddef>
#include <string>

#include "takt/base/result.hpp"

namespace takt::file {

inline constexpr std::size_t kMaxSecretBytes = 64 << 10;      ///< of a file with a password or a private key
inline constexpr std::size_t kMaxCertificateBytes = 4 << 20;  ///< the bundles of systems have 200 to 300 KiB

/// Whether read_file() could read the file, without reading it. @returns the errors of read_file()
[[nodiscard]] Result<void> check_readable(const std::string& path, std::size_t limit);

/// Reads a whole regular file. Never blocks: pipes, devices and sockets are refused without being opened.
///
/// Errors, with the path as their subject: cannot_open (operating system's number; EISDIR for a directory),
/// unsupported (not a regular file), too_long (bytes there as far as known, bytes allowed), io_failed
/// (operating system's number).
[[nodiscard]] Result<std::string> read_file(const std::string& path, std::size_t limit);

}  // namespace takt::file
