#include "takt/console/capture_file.hpp"

#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "takt/os/open.hpp"

namespace takt::console {
namespace {

constexpr int kStallTimeoutMs = 2000;  // of the reader of a pipe

}  // namespace

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
    if (!rest_.empty()) {
        const auto done = write_some(rest_);
        rest_.erase(0, done.bytes);
        if (!rest_.empty()) return fail(Code::io_failed, options_.path, done.error);
    }
    const auto done = write_some(blocks);
    if (done.error == 0) {
        size_ += blocks.size();
        return {};
    }
    const auto whole = static_cast<::off_t>(size_);
    if (regular_ && done.bytes > 0 && ::ftruncate(file_.get(), whole) == 0)
        (void)::lseek(file_.get(), whole, SEEK_SET);
    if (regular_ || done.bytes == 0) return fail(Code::io_failed, options_.path, done.error);
    rest_ = blocks.substr(done.bytes);  // a reader has the begin of a block
    return {};
}

CaptureFile::Done CaptureFile::write_some(std::string_view bytes) const {
    Done done;
    while (done.bytes < bytes.size()) {
        const auto count = ::write(file_.get(), bytes.data() + done.bytes, bytes.size() - done.bytes);
        if (count >= 0) {
            done.bytes += static_cast<std::size_t>(count);
            continue;
        }
        if (errno == EINTR) continue;
        done.error = errno;
        pollfd waited{.fd = file_.get(), .events = POLLOUT, .revents = 0};
        if (done.error != EAGAIN || ::poll(&waited, 1, kStallTimeoutMs) <= 0) return done;
        done.error = 0;
    }
    return done;
}

}  // namespace takt::console
