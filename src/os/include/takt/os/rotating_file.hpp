// A log file of bounded size with a number of older ones.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "takt/base/result.hpp"
#include "takt/os/open.hpp"
#include "takt/os/sink.hpp"

namespace takt::os {

/// A file of at most `file_bytes`, and the `old_files` before it as PATH.1 (the newest), PATH.2, …
///
/// A text that does not fit into the current file begins the next one; a text that is larger than a file may
/// be is divided at line ends. A line longer than `file_bytes` gets a file of its own. Where the folder does
/// not allow renaming, the current file grows beyond its size instead of losing lines. So it does behind a
/// link of the system (/dev/stdout), which is never renamed.
///
/// A failed write leaves no part of a line behind and does not close the file: the next write tries again.
/// One thread.
class RotatingFile final : public Sink {
public:
    struct Options {
        std::size_t file_bytes = 10 << 20;  ///< > 0
        unsigned old_files = 5;             ///< 0: the file is truncated when it is full
        ::mode_t mode = kStateFileMode;     ///< of new files, less the umask
        /// The file is made empty at the beginning, and locked against other programs, as by open_anew().
        bool anew = false;
        /// With `anew`: reports that a full file goes on because the next one cannot begin, once until one
        /// begins. Called by write() with an error of begin_next_file().
        std::function<void(const Error&)> on_not_rotated = {};
    };

    /// Opens or creates the file; without `anew` it is appended to.
    /// @returns as open_for_append() or open_anew()
    [[nodiscard]] static Result<std::unique_ptr<RotatingFile>> open(const std::string& path,
                                                                    const Options& options);

    /// @param text  whole lines
    Written write(std::string_view text) override;

private:
    RotatingFile(std::string path, const Options& options);
    [[nodiscard]] std::string numbered(unsigned number) const;
    [[nodiscard]] Result<void> reopen();
    void rotate();
    void begin_next();
    [[nodiscard]] std::size_t piece_end(std::string_view text, std::size_t begin) const;
    Written failed(std::string_view text, std::size_t done, int error);

    std::string path_;
    Options options_;
    Descriptor file_;
    std::size_t size_ = 0;
    bool rotation_failed_ = false;
    std::size_t limit_;  // of the current file; it is larger after a rotation that failed
};

}  // namespace takt::os
