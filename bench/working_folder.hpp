// A folder for the files of a benchmark, on a disk that the user chooses.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

namespace takt::bench {

/// A benchmark cannot go on; the text is for the user.
struct Failure : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// SIGINT and SIGTERM let the next check_interrupted() throw, so that folders are removed.
void catch_signals();
void check_interrupted();

/// A new folder, which is removed with everything in it.
class WorkingFolder {
public:
    /// Throws Failure.
    explicit WorkingFolder(const std::string& parent);
    ~WorkingFolder();
    WorkingFolder(const WorkingFolder&) = delete;
    WorkingFolder& operator=(const WorkingFolder&) = delete;

    [[nodiscard]] const std::string& path() const { return path_; }
    [[nodiscard]] std::string operator/(const std::string& name) const { return path_ + "/" + name; }
    /// A new folder in it.
    [[nodiscard]] std::string make(const std::string& name) const;
    /// What its disk has left for this user.
    [[nodiscard]] std::uint64_t free_bytes() const;

private:
    std::string path_;
};

}  // namespace takt::bench
