#include "takt/os/open.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>

#include "takt/os/replace.hpp"

namespace takt::os {
namespace {

constexpr int kAlways = O_CLOEXEC | O_NOCTTY | O_NONBLOCK;

Result<void> check_type(const struct stat& status, const std::string& path, bool fifo) {
    if (S_ISDIR(status.st_mode)) return fail(Code::cannot_open, path, EISDIR);
    if (fifo && S_ISFIFO(status.st_mode)) return {};
    if (!S_ISREG(status.st_mode)) return fail(Code::unsupported, path);
    return {};
}

bool names_device(const std::filesystem::path& path) {
    constexpr std::array kFolders{"/dev", "/dev/fd", "/dev/pts", "/proc/self/fd"};
    return path == path.lexically_normal() &&
           std::ranges::find(kFolders, path.parent_path()) != kFolders.end();
}

/// A link under these folders, and one that leads there, is followed: /dev/stdout is a link.
/// @returns the path to open; empty: the link is refused
std::string device_of_link(const std::string& path) {
    if (names_device(path)) return path;
    std::error_code error;
    const auto target = std::filesystem::read_symlink(path, error);
    return !error && names_device(target) ? target.string() : std::string();
}

/// With O_NOFOLLOW a link is refused with ELOOP, because another user may have created it.
Descriptor open_path(const std::string& path, int flags) {
    Descriptor file(::open(path.c_str(), flags | kAlways));
    if (file || errno != ELOOP || (flags & O_NOFOLLOW) == 0) return file;
    const std::string device = device_of_link(path);
    errno = ELOOP;
    return device.empty() ? Descriptor()
                          : Descriptor(::open(device.c_str(), (flags & ~O_NOFOLLOW) | kAlways));
}

Result<Descriptor> open_existing(const std::string& path, int flags, bool fifo = false) {
    if (path.find('\0') != std::string::npos) return fail(Code::cannot_open, path, ENOENT);
    struct stat status{};
    if (::stat(path.c_str(), &status) != 0) return fail(Code::cannot_open, path, errno);
    TAKT_CHECK(check_type(status, path, fifo));
    auto file = open_path(path, flags);
    if (!file) return fail(Code::cannot_open, path, errno);
    // Another program may have replaced the file since stat().
    if (::fstat(file.get(), &status) != 0) return fail(Code::cannot_open, path, errno);
    TAKT_CHECK(check_type(status, path, fifo));
    return file;
}

Result<Descriptor> create(const std::string& path, int flags, ::mode_t mode) {
    if (path.find('\0') != std::string::npos) return fail(Code::cannot_open, path, ENOENT);
    Descriptor file(::open(path.c_str(), flags | kAlways | O_CREAT | O_EXCL | O_NOFOLLOW, mode));
    if (!file) return fail(Code::cannot_open, path, errno);
    TAKT_CHECK(sync_folder(path));
    return file;
}

bool is_errno(const Result<Descriptor>& opened, int number) {
    return !opened && opened.error().code == Code::cannot_open && opened.error().numbers[0] == number;
}

/// A file of any type, not through a link.
Result<Descriptor> open_or_create(const std::string& path, int flags, ::mode_t mode) {
    if (path.find('\0') != std::string::npos) return fail(Code::cannot_open, path, ENOENT);
    auto file = open_path(path, flags | O_NOFOLLOW);
    if (file) return file;
    if (errno != ENOENT) return fail(Code::cannot_open, path, errno);
    auto created = create(path, flags, mode);
    if (!is_errno(created, EEXIST)) return created;
    // Another program has created it meanwhile.
    file = open_path(path, flags | O_NOFOLLOW);
    if (!file) return fail(Code::cannot_open, path, errno);
    return file;
}

}  // namespace

Result<Descriptor> open_for_reading(const std::string& path) {
    return open_existing(path, O_RDONLY);
}

Result<Descriptor> open_stream(const std::string& path) {
    return open_existing(path, O_RDONLY, true);
}

Result<Descriptor> open_for_update(const std::string& path) {
    return open_existing(path, O_RDWR);
}

Result<Descriptor> open_for_append(const std::string& path, ::mode_t mode) {
    constexpr int kFlags = O_WRONLY | O_APPEND;
    auto file = open_existing(path, kFlags | O_NOFOLLOW);
    if (!is_errno(file, ENOENT)) return file;
    file = create(path, kFlags, mode);
    // Another program may have created it meanwhile.
    return is_errno(file, EEXIST) ? open_existing(path, kFlags | O_NOFOLLOW) : std::move(file);
}

Result<Descriptor> open_anew(const std::string& path, ::mode_t mode) {
    TAKT_TRY(auto file, open_or_create(path, O_WRONLY | O_APPEND, mode));
    struct stat status{};
    if (::fstat(file.get(), &status) != 0) return fail(Code::cannot_open, path, errno);
    if (!S_ISREG(status.st_mode)) return file;
    // Any other error is of a file system without locks.
    if (::flock(file.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return fail(Code::busy, path);
    // The program that had the lock may have renamed the file meanwhile.
    if (!is_at(file.get(), path)) return fail(Code::busy, path);
    if (::ftruncate(file.get(), 0) != 0) return fail(Code::io_failed, path, errno);
    return file;
}

Result<Descriptor> create_file(const std::string& path, ::mode_t mode) {
    return create(path, O_RDWR, mode);
}

bool is_at(int descriptor, const std::string& path) {
    struct stat open_file{};
    struct stat named{};
    return ::fstat(descriptor, &open_file) == 0 && ::stat(path.c_str(), &named) == 0 &&
           open_file.st_dev == named.st_dev && open_file.st_ino == named.st_ino;
}

Result<std::string> read_all(int descriptor, const std::string& path, std::size_t limit) {
    constexpr std::size_t kChunk = 64 << 10;
    std::string bytes;
    for (;;) {
        const auto before = bytes.size();
        bytes.resize(before + kChunk);
        const auto count = ::read(descriptor, bytes.data() + before, kChunk);
        if (count < 0 && errno != EINTR) return fail(Code::io_failed, path, errno);
        bytes.resize(before + (count > 0 ? static_cast<std::size_t>(count) : 0));
        if (bytes.size() > limit)
            return fail(Code::too_long, path, static_cast<std::int64_t>(bytes.size()),
                        static_cast<std::int64_t>(limit));
        if (count == 0) return bytes;
    }
}

bool write_all(int descriptor, std::string_view bytes) {
    while (!bytes.empty()) {
        const auto written = ::write(descriptor, bytes.data(), bytes.size());
        if (written < 0 && errno != EINTR) return false;
        if (written > 0) bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return true;
}

}  // namespace takt::os
