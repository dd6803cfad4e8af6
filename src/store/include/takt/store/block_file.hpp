// A file that is written in place, as a seam: the real one, or one that loses what was not synchronised.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"

namespace takt::store {

/// What was written before a sync() that succeeded survives a power cut. What was written since may be there,
/// in any order and torn anywhere, or not. One thread at a time.
class BlockFile {
public:
    virtual ~BlockFile() = default;

    /// @returns how many bytes there are
    [[nodiscard]] virtual Result<std::uint64_t> size() = 0;
    /// Fills `into`. @returns too_short (bytes there, bytes needed), io_failed
    [[nodiscard]] virtual Result<void> read_at(std::uint64_t offset, std::span<std::uint8_t> into) = 0;
    /// @returns io_failed: some of the bytes may be there, now or after the next sync()
    [[nodiscard]] virtual Result<void> write_at(std::uint64_t offset, Bytes bytes) = 0;
    /// @returns io_failed: it is not known what of the bytes written since the last one is there
    [[nodiscard]] virtual Result<void> sync() = 0;
};

/// A file that exists, for this program alone as long as it is open.
/// @returns not_found (path), busy (another program has it), unsupported (path: a device, a pipe, a socket;
///          it is not even opened), cannot_open (path, system's error number)
[[nodiscard]] Result<std::unique_ptr<BlockFile>> open_block_file(const std::string& path);

/// A file of zeros with its place on the disk reserved, under that path once publish() was called; until then
/// under a name of its own beside it, which is removed when the file is closed.
class NewBlockFile {
public:
    /// @param mark  what such a file begins with, once it is written: what else has the name beside the path
    ///              is somebody else's
    /// @returns cannot_open, busy, unsupported (the name beside it), io_failed (path, system's error number:
    ///          28, the disk is full)
    [[nodiscard]] static Result<NewBlockFile> make(const std::string& path, std::uint64_t size,
                                                   std::string_view mark);
    ~NewBlockFile();
    NewBlockFile(NewBlockFile&&) noexcept;
    NewBlockFile& operator=(NewBlockFile&&) = delete;

    [[nodiscard]] BlockFile& file() { return *file_; }

    /// Puts it in the place of whatever is under the path, for good.
    [[nodiscard]] Result<std::unique_ptr<BlockFile>> publish();

private:
    NewBlockFile(std::string path, std::string temporary, std::unique_ptr<BlockFile> file);

    std::string path_;
    std::string temporary_;
    std::unique_ptr<BlockFile> file_;  // none: published
};

}  // namespace takt::store
