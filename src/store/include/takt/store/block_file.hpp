// A file that is written in place. An interface, so that a test can lose what was not synchronised.
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

/// Bytes that were written before a successful sync() survive a power cut. Of the bytes written since, any
/// part may be on the disk. One thread at a time.
class BlockFile {
public:
    virtual ~BlockFile() = default;

    /// @returns the size in bytes
    [[nodiscard]] virtual Result<std::uint64_t> size() = 0;
    /// Fills `into`. @returns too_short (bytes there, bytes needed), io_failed
    [[nodiscard]] virtual Result<void> read_at(std::uint64_t offset, std::span<std::uint8_t> into) = 0;
    /// @returns io_failed: some of the bytes may be there, now or after the next sync()
    [[nodiscard]] virtual Result<void> write_at(std::uint64_t offset, Bytes bytes) = 0;
    /// @returns io_failed: any part of the bytes written since the last one may be on the disk
    [[nodiscard]] virtual Result<void> sync() = 0;
};

/// Opens an existing file and locks it against other programs for as long as it is open.
/// @returns not_found (path), busy (another program has it open), unsupported (path: not a regular file; it
/// is
///          not opened), cannot_open (path, system's error number)
[[nodiscard]] Result<std::unique_ptr<BlockFile>> open_block_file(const std::string& path);

/// A new file of zeros with its space on the disk reserved. It has a temporary name, PATH.new, until
/// publish(), and is removed when it is destroyed without it.
class NewBlockFile {
public:
    /// @param mark  the first bytes of such a file, once it is written. An existing file with the temporary
    ///              name is overwritten only if it begins with the mark or with zeros
    /// @returns cannot_open, busy, unsupported (the temporary name), io_failed (path, system's error number:
    ///          28, the disk is full)
    [[nodiscard]] static Result<NewBlockFile> make(const std::string& path, std::uint64_t size,
                                                   std::string_view mark);

    [[nodiscard]] BlockFile& file() { return *file_; }

    /// Replaces the file under the path, durably. @returns the file, which stays locked
    [[nodiscard]] Result<std::unique_ptr<BlockFile>> publish();

private:
    NewBlockFile(os::FileReplacement replacement, std::unique_ptr<BlockFile> file);

    os::FileReplacement replacement_;
    std::unique_ptr<BlockFile> file_;
};

}  // namespace takt::store
