// The project file on the disk.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "takt/base/result.hpp"
#include "takt/file/load.hpp"

namespace takt::web {

/// One state of the file.
struct SavedProject {
    std::string text;
    std::string revision;  ///< of these bytes
    file::Loaded alone;    ///< as file::read_project_text()
};

/// A number for the bytes of a file (FNV-1a, 64 bits) and their count, as text.
[[nodiscard]] std::string revision_of(std::string_view bytes);

/// Reads the file each time, and parses it only after a change. Any thread.
class ProjectOnDisk {
public:
    explicit ProjectOnDisk(std::string file) : file_(std::move(file)) {}

    /// @returns the errors of file::read_file()
    [[nodiscard]] Result<std::shared_ptr<const SavedProject>> read();

private:
    const std::string file_;
    std::mutex mutex_;
    std::shared_ptr<const SavedProject> last_;
};

}  // namespace takt::web
