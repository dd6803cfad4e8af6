#include "takt/store/block_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <utility>
#include <vector>

namespace takt::store {
namespace {

class RealFile final : public BlockFile {
public:
    RealFile(int fd, std::string path) : fd_(fd), path_(std::move(path)) {}
    ~RealFile() override { ::close(fd_); }
    RealFile(const RealFile&) = delete;
    RealFile& operator=(const RealFile&) = delete;

    Result<std::uint64_t> size() override {
        struct stat status{};
        if (::fstat(fd_, &status) != 0) return failed();
        return static_cast<std::uint64_t>(status.st_size);
    }

    Result<void> read_at(std::uint64_t offset, std::span<std::uint8_t> into) override {
        std::size_t done = 0;
        while (done < into.size()) {
            const auto got =
                ::pread(fd_, into.data() + done, into.size() - done, static_cast<off_t>(offset + done));
            if (got < 0 && errno == EINTR) continue;
            if (got < 0) return failed();
            if (got == 0)
                return fail(Code::too_short, path_, static_cast<std::int64_t>(offset + done),
                            static_cast<std::int64_t>(offset + into.size()));
            done += static_cast<std::size_t>(got);
        }
        return {};
    }

    Result<void> write_at(std::uint64_t offset, Bytes bytes) override {
        std::size_t done = 0;
        while (done < bytes.size()) {
            const auto put =
                ::pwrite(fd_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
            if (put < 0 && errno == EINTR) continue;
            if (put <= 0) return failed();
            done += static_cast<std::size_t>(put);
        }
        return {};
    }

    Result<void> sync() override {
        if (::fdatasync(fd_) != 0) return failed();
        return {};
    }

    /// @returns busy
    Result<void> lock() {
        if (::flock(fd_, LOCK_EX | LOCK_NB) != 0) return fail(Code::busy, path_, errno);
        return {};
    }
    Result<void> reserve(std::uint64_t size) {
        if (const int error = ::posix_fallocate(fd_, 0, static_cast<off_t>(size)); error != 0)
            return fail(Code::io_failed, path_, error);
        return {};
    }
    Result<void> sync_all() {
        if (::fsync(fd_) != 0) return failed();
        return {};
    }

private:
    [[nodiscard]] std::unexpected<Error> failed() const { return fail(Code::io_failed, path_, errno); }

    int fd_;
    std::string path_;
};

/// Makes what was renamed in the directory of `path` durable.
Result<void> sync_directory(const std::string& path) {
    auto directory = std::filesystem::path(path).parent_path().string();
    if (directory.empty()) directory = ".";
    const int fd = ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) return fail(Code::cannot_open, directory, errno);
    const bool synced = ::fsync(fd) == 0;
    const int error = errno;
    ::close(fd);
    if (!synced) return fail(Code::io_failed, directory, error);
    return {};
}

/// Opening a device may do something already.
bool is_something_else(const std::string& path) {
    struct stat status{};
    return ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

bool is_link(const std::string& path) {
    struct stat status{};
    return ::lstat(path.c_str(), &status) == 0 && S_ISLNK(status.st_mode);
}

/// What a file that was never published was left as: empty, zeros, or with its beginning written.
Result<bool> is_unfinished(BlockFile& file, std::string_view mark) {
    TAKT_TRY(const auto size, file.size());
    std::vector<std::uint8_t> head(std::min<std::uint64_t>(size, mark.size()));
    TAKT_CHECK(file.read_at(0, head));
    const bool zeros = std::ranges::all_of(head, [](std::uint8_t byte) { return byte == 0; });
    return zeros || std::string_view(reinterpret_cast<const char*>(head.data()), head.size()) == mark;
}

}  // namespace

Result<std::unique_ptr<BlockFile>> open_block_file(const std::string& path) {
    if (is_something_else(path)) return fail(Code::unsupported, path);
    const int fd = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
    // A link that leads nowhere is there, and not to be replaced.
    if (fd < 0) {
        const int error = errno;
        return fail(error == ENOENT && !is_link(path) ? Code::not_found : Code::cannot_open, path, error);
    }
    auto file = std::make_unique<RealFile>(fd, path);
    TAKT_CHECK(file->lock());
    return file;
}

NewBlockFile::NewBlockFile(std::string path, std::string temporary, std::unique_ptr<BlockFile> file)
    : path_(std::move(path)), temporary_(std::move(temporary)), file_(std::move(file)) {}
NewBlockFile::NewBlockFile(NewBlockFile&&) noexcept = default;

NewBlockFile::~NewBlockFile() {
    if (file_) ::unlink(temporary_.c_str());
}

Result<NewBlockFile> NewBlockFile::make(const std::string& path, std::uint64_t size, std::string_view mark) {
    std::string temporary = path + ".new";
    if (is_something_else(temporary)) return fail(Code::unsupported, temporary);
    constexpr mode_t kMode = 0644;
    const int fd = ::open(temporary.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, kMode);
    if (fd < 0) return fail(Code::cannot_open, temporary, errno);
    auto file = std::make_unique<RealFile>(fd, path);
    TAKT_CHECK(file->lock());
    TAKT_TRY(const bool ours, is_unfinished(*file, mark));
    if (!ours) return fail(Code::unsupported, temporary);
    if (::ftruncate(fd, 0) != 0) return fail(Code::io_failed, temporary, errno);
    RealFile& real = *file;
    NewBlockFile made(path, std::move(temporary), std::move(file));
    TAKT_CHECK(real.reserve(size));
    return made;
}

Result<std::unique_ptr<BlockFile>> NewBlockFile::publish() {
    TAKT_CHECK(static_cast<RealFile&>(*file_).sync_all());
    if (::rename(temporary_.c_str(), path_.c_str()) != 0) return fail(Code::io_failed, path_, errno);
    auto file = std::move(file_);
    TAKT_CHECK(sync_directory(path_));
    return file;
}

}  // namespace takt::store
