// A file that is written in place, as an interface: the real file, or a test file that loses unsynchronised
// writes.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
#include "takt/os/replace.hpp"

namespace takt::store {

/// Bytes written before a successful sync() survive a power cut. Later writes may survive in any order,
/// partly, or not at all. One thread at a time.
class BlockFile {
public:
    virtual ~BlockFile() = default;

    /// @returns the size in bytes
    [[nodiscard]] virtual Result<std::uint64_t> size() = 0;
    /// Fills `into`. @returns too_short (bytes there, bytes needed), io_failed
    [[nodiscard]] virtual Result<void> read_at(std::uint64_t offset, std::span<std::uint8_t> into) = 0;
    /// @returns io_failed: some of the bytes may be there, now or after the next sync()
    [[nodiscard]] virtual Result<void> write_at(std::uint64_t offset, Bytes bytes) = 0;
    /// @returns io_failed: the state of the bytes written since the last successful sync() is unknown;
    ///          replaced: the path leads to another file or to none, a restart would not find the bytes
    [[nodiscard]] virtual Result<void> sync() = 0;
};

/// Opens an existing file and locks it against other programs for as long as it is open.
/// @returns not_found (path), busy (another program has it open), unsupported (path: not a regular file; it
///          is not opened), cannot_open (path, system's error number)
[[nodiscard]] Result<std::unique_ptr<BlockFile>> open_block_file(const std::string& path);

/// A new file of zeros with reserved disk space. publish() gives it its path; before that it has a temporary
/// name next to the path and is removed when closed.
class NewBlockFile {
public:
    /// @param mark  magic number of the format. A file under the temporary name without it belongs to another
    ///              program and is never overwritten
    /// @returns cannot_open, busy, unsupported (the name beside it), io_failed (path, system's error number:
    ///          28, the disk is full)
    [[nodiscard]] static Result<NewBlockFile> make(const std::string& path, std::uint64_t size,
                                                   std::string_view mark);

    [[nodiscard]] BlockFile& file() { return *file_; }

    /// Renames the file to its path, replacing any file there, and synchronises the directory.
    [[nodiscard]] Result<std::unique_ptr<BlockFile>> publish();

private:
    NewBlockFile(os::FileReplacement replacement, std::unique_ptr<BlockFile> file);

    os::FileReplacement replacement_;
    std::unique_ptr<BlockFile> file_;
};

}  // namespace takt::store
