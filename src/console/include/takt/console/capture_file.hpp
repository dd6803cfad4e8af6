// A capture on disk: a file of bounded size, and a bounded number of those before it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "takt/base/result.hpp"
#include "takt/os/descriptor.hpp"

namespace takt::console {

struct CaptureFileOptions {
    std::string path;
    std::uint64_t file_bytes = 100'000'000;  ///< of one file; > 0
    unsigned files = 10;                     ///< with the current one; > 0
};

/// Writes whole pcapng blocks. When the next ones do not fit, PATH becomes PATH with ".1" before its
/// extension, ".1" becomes ".2", and so on; the oldest is removed. An existing PATH is overwritten, unless
/// another program has it locked; older files are left until a new one takes their name. A FIFO, a device and
/// a file behind a link of the system (/dev/stdout) grow without rotation.
///
/// A failed write leaves no part of a block behind, and does not close the file: the next write tries again.
/// A pipe whose reader takes nothing for 2 s is a failure; the rest of what it has in part comes first
/// then. One thread.
class CaptureFile {
public:
    /// @returns as os::open_anew()
    [[nodiscard]] static Result<CaptureFile> open(const CaptureFileOptions& options);

    [[nodiscard]] const std::string& path() const { return options_.path; }

    /// Whether a rotation must come before that many bytes more.
    [[nodiscard]] bool is_full(std::size_t bytes) const { return size_ + bytes > limit_; }

    /// Begins the next file.
    /// @returns as os::begin_next_file(); then the file goes on, and is full again after `file_bytes` more
    [[nodiscard]] Result<void> rotate();

    /// @param blocks  whole blocks
    /// @returns io_failed (the system's error number)
    [[nodiscard]] Result<void> write(std::string_view blocks);

    /// "a.pcapng", 2 becomes "a.2.pcapng"; 0 is the path itself.
    [[nodiscard]] static std::string numbered(const std::string& path, unsigned number);

private:
    explicit CaptureFile(CaptureFileOptions options)
        : options_(std::move(options)), limit_(options_.file_bytes) {}
    struct Done {
        std::size_t bytes = 0;
        int error = 0;  // why not all was written
    };
    [[nodiscard]] Result<void> begin();
    [[nodiscard]] Done write_some(std::string_view bytes) const;

    CaptureFileOptions options_;
    os::Descriptor file_;
    bool regular_ = true;
    std::uint64_t size_ = 0;
    std::uint64_t limit_;  // of the size
    std::string rest_;     // of blocks that a pipe has in part
};

}  // namespace takt::console
