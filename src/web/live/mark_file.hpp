// Marks on the disk: a file of JSON lines.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "live/marks.hpp"
#include "takt/base/result.hpp"
#include "takt/os/descriptor.hpp"

namespace takt::web {

/// The file that keeps marks over a restart. One owner, one thread; every call may wait for the disk.
///
/// The first line is {"takt":"marks","version":1,"since":MS}. Each further line is a mark: {"time","kind",
/// "severity","outcome"?,"origin"?,"en","ru","uk"}. One program at a time has the file (flock).
class MarkFile {
public:
    static constexpr std::size_t kMostBytes = std::size_t{8} << 20;
    static constexpr std::size_t kMostLines = 4 * Marks::kMost;

    struct Opened;

    /// Opens the file, or creates it. The end of a line that a power cut left is cut off. A file with other
    /// lines that are no marks is moved to the first free of "PATH.damaged-1" to "-999", and its marks go to
    /// a new file.
    /// @param since_ms  of a new file
    /// @returns busy (another program has it); unsupported (of a newer version, or not a regular file: it is
    ///          left alone); cannot_open, io_failed, queue_full (no free name)
    [[nodiscard]] static Result<Opened> open(const std::string& path, std::int64_t since_ms);

    /// Appends marks. After a failure none of them is in the file.
    /// @returns io_failed (28: the disk is full); replaced: the file was changed, moved or removed by
    ///          another program. write_anew() mends that
    [[nodiscard]] Result<void> append(std::span<const Mark> marks);

    /// Replaces the contents in one step. Of more than half of kMostBytes the oldest marks are left out.
    /// @returns as os::FileReplacement
    [[nodiscard]] Result<void> write_anew(std::int64_t since_ms, std::span<const Mark> marks);

    /// Whether append() has made the file so large that write_anew() is due.
    [[nodiscard]] bool is_large() const { return size_ > kMostBytes || lines_ > kMostLines; }

private:
    MarkFile(std::string path, os::Descriptor file) : path_(std::move(path)), file_(std::move(file)) {}
    [[nodiscard]] bool is_unchanged() const;
    [[nodiscard]] Result<void> cut_to(std::size_t size);

    std::string path_;
    os::Descriptor file_;  // locked; at its end
    std::size_t size_ = 0;
    std::size_t lines_ = 0;
};

struct MarkFile::Opened {
    std::unique_ptr<MarkFile> file;
    std::int64_t since_ms = 0;
    std::vector<Mark> marks;
    std::size_t cut_bytes = 0;  ///< that were cut off at the end
    std::string set_aside;      ///< where a damaged file was moved; empty: there was none
};

}  // namespace takt::web
