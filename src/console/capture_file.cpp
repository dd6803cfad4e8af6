#include "takt/console/capture_file.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "takt/os/open.hpp"

namespace takt::console {

Result<CaptureFile> CaptureFile::open(const CaptureFileOptions& options) {
    CaptureFile file(options);
    TAKT_CHECK(file.begin());
    return file;
}

Result<void> CaptureFile::begin() {
    TAKT_TRY(file_, os::open_anew(options_.path));
    struct stat status{};
    regular_ = ::fstat(file_.get(), &status) == 0 && S_ISREG(status.st_mode);
    size_ = 0;
    return {};
}

std::string CaptureFile::numbered(const std::string& path, unsigned number) {
    if (number == 0) return path;
    const std::filesystem::path whole(path);
    auto name = whole.stem().string() + '.' + std::to_string(number) + whole.extension().string();
    return (whole.parent_path() / name).string();
}

Result<void> CaptureFile::rotate() {
    for (unsigned number = options_.files - 1; number-- > 0;) {
        const auto from = numbered(options_.path, number);
        const bool renamed = std::rename(from.c_str(), numbered(options_.path, number + 1).c_str()) == 0;
        if (renamed || number > 0) continue;
        regular_ = false;  // the folder does not allow it: the file grows instead of losing frames
        return {};
    }
    file_.reset();
    return begin();
}

Result<void> CaptureFile::write(std::string_view blocks) {
    if (!file_) TAKT_CHECK(begin());
    std::size_t done = 0;
    while (done < blocks.size()) {
        const auto count = ::write(file_.get(), blocks.data() + done, blocks.size() - done);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) {
            const int number = count < 0 ? errno : EIO;
            const auto whole = static_cast<::off_t>(size_);
            if (done > 0 && ::ftruncate(file_.get(), whole) == 0) (void)::lseek(file_.get(), whole, SEEK_SET);
            return fail(Code::io_failed, options_.path, number);
        }
        done += static_cast<std::size_t>(count);
    }
    size_ += blocks.size();
    return {};
}

}  // namespace takt::console
