#include "takt/console/capture_file.hpp"

#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <utility>

#include "takt/os/open.hpp"
#include "takt/os/rotation.hpp"

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
    std::error_code unknown;  // is no link
    if (!regular_ || std::filesystem::is_symlink(options_.path, unknown)) limit_ = UINT64_MAX;
    return {};
}

std::string CaptureFile::numbered(const std::string& path, unsigned number) {
    if (number == 0) return path;
    const std::filesystem::path whole(path);
    auto name = whole.stem().string() + '.' + std::to_string(number) + whole.extension().string();
    return (whole.parent_path() / name).string();
}

Result<void> CaptureFile::rotate() {
    auto next = os::begin_next_file(file_.get(), options_.files - 1,
                                    [this](unsigned number) { return numbered(options_.path, number); });
    limit_ = options_.file_bytes + (next ? 0 : size_);
    if (!next) return std::unexpected(next.error());
    file_ = *std::move(next);
    size_ = 0;
    return {};
}

Result<void> CaptureFile::write(std::string_view blocks) {
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
    if (regular_ || done.bytes == 0) {
        if (done.bytes > 0) (void)::ftruncate(file_.get(), static_cast<::off_t>(size_));
        return fail(Code::io_failed, options_.path, done.error);
    }
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
