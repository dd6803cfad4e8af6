// Preloaded into `takt run` (LD_PRELOAD) by output_kills.py. The functions below replace those of libc; they
// make the system calls themselves, so that a sanitizer in the program does not matter.
//
//   TAKT_SYNC_LOG  a file: each successful sync of a segment or cursor adds the line `PATH SIZE CONTENT`, as
//                  the file was before the sync. CONTENT is the one of a cursor in hex, `-` of a segment.
//   TAKT_KILL_AT   CALL:COUNT:WHEN: kills the program with SIGKILL at the COUNTth call. WHEN is `before`,
//                  `after` or `torn`: after a part of the bytes was written.
//
//   TAKT_TROUBLE   a file with two 64-bit numbers that may change at any time: nanoseconds by which the wall
//                  clock is wrong, and whether no file of the program can grow (ENOSPC).
//
//   TAKT_REMOVED   a folder with one for each journal: removed segments are linked there first.
//
//   append, sync          bytes of a segment
//   slot, slot_sync       bytes of a cursor
//   create, remove        a segment
//   send, receive         a TCP connection
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>
#include <string_view>

namespace {

using Path = std::array<char, 4096>;

[[noreturn]] void die() {
    for (;;) ::syscall(SYS_kill, ::syscall(SYS_getpid), SIGKILL);
}

/// The point of death, from the environment.
class KillPoint {
public:
    KillPoint() {
        const char* const text = std::getenv("TAKT_KILL_AT");
        if (text == nullptr) return;
        const std::string_view all(text);
        const auto first = all.find(':');
        const auto last = all.rfind(':');
        call_ = all.substr(0, first);
        left_ = std::atoi(text + first + 1);
        when_ = all.substr(last + 1);
    }

    /// Before a call. @returns whether the program is to die in it
    bool reached(std::string_view call) {
        if (call.empty() || call != call_ || --left_ != 0) return false;
        if (when_ == "before") die();
        return true;
    }
    [[nodiscard]] bool torn() const { return when_ == "torn"; }

private:
    std::string_view call_;
    std::string_view when_;
    std::atomic<int> left_ = 0;
};

KillPoint& kill_point() {
    static KillPoint point;
    return point;
}

/// `segment`, `cursor`, or empty: the kind of a file by its name.
std::string_view kind_of(const char* path) {
    const char* const slash = std::strrchr(path, '/');
    const std::string_view name(slash != nullptr ? slash + 1 : path);
    if (name.starts_with("segment-")) return "segment";
    if (name.starts_with("cursor-")) return "cursor";
    return {};
}

std::string_view kind_of(int file, Path& path) {
    std::array<char, 40> link{};
    (void)std::snprintf(link.data(), link.size(), "/proc/self/fd/%d", file);
    const auto size = ::syscall(SYS_readlink, link.data(), path.data(), path.size() - 1);
    if (size <= 0) return {};
    path[static_cast<std::size_t>(size)] = 0;
    if (std::strncmp(path.data(), "socket:", 7) != 0) return kind_of(path.data());
    sockaddr_storage peer{};
    socklen_t length = sizeof peer;
    if (::syscall(SYS_getpeername, file, &peer, &length) != 0) return {};
    return peer.ss_family == AF_INET || peer.ss_family == AF_INET6 ? "socket" : std::string_view();
}

std::string_view name_of_write(std::string_view kind) {
    if (kind == "segment") return "append";
    if (kind == "cursor") return "slot";
    return kind == "socket" ? "send" : std::string_view();
}

template <typename Call>
auto guarded(std::string_view name, const Call& call) {
    const bool last = kill_point().reached(name);
    const auto result = call();
    if (last) die();
    return result;
}

/// The numbers of TAKT_TROUBLE.
struct Trouble {
    std::atomic<std::int64_t> clock_offset_ns = 0;
    std::atomic<std::int64_t> disk_full = 0;
};

Trouble& trouble() {
    static Trouble none;
    static Trouble* const shared = [] {
        const char* const path = std::getenv("TAKT_TROUBLE");
        if (path == nullptr) return &none;
        const long file = ::syscall(SYS_openat, AT_FDCWD, path, O_RDWR | O_CLOEXEC, 0);
        void* const memory =
            ::mmap(nullptr, sizeof(Trouble), PROT_READ | PROT_WRITE, MAP_SHARED, static_cast<int>(file), 0);
        return memory == MAP_FAILED ? &none : static_cast<Trouble*>(memory);
    }();
    return *shared;
}

bool has_no_space(int file) {
    struct stat status{};
    return trouble().disk_full != 0 && file > STDERR_FILENO && ::fstat(file, &status) == 0 &&
           S_ISREG(status.st_mode);
}

template <typename Call>
ssize_t write_to(int file, std::size_t size, const Call& call) {
    if (has_no_space(file)) {
        errno = ENOSPC;
        return -1;
    }
    Path path;
    const auto name = name_of_write(kind_of(file, path));
    if (!kill_point().reached(name)) return call(size);
    (void)call(kill_point().torn() ? size / 2 : size);
    die();
}

std::string line_for(const char* path, std::string_view kind, int file) {
    struct stat status{};
    if (::fstat(file, &status) != 0) return {};
    std::string line = std::string(path) + ' ' + std::to_string(status.st_size) + ' ';
    if (kind == "segment") return line + "-\n";
    std::array<unsigned char, 16384> content{};
    const auto size = ::syscall(SYS_pread64, file, content.data(), content.size(), 0);
    for (long i = 0; i < size; ++i) {
        std::array<char, 3> hex{};
        (void)std::snprintf(hex.data(), hex.size(), "%02x", content[static_cast<std::size_t>(i)]);
        line += hex.data();
    }
    return line + '\n';
}

void add_to_log(const std::string& line) {
    static const char* const path = std::getenv("TAKT_SYNC_LOG");
    if (path == nullptr || line.empty()) return;
    static const long log =
        ::syscall(SYS_openat, AT_FDCWD, path, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0600);
    (void)::syscall(SYS_write, log, line.data(), line.size());
}

int sync_with(long number, int file) {
    Path path;
    const auto kind = kind_of(file, path);
    const std::string line =
        kind.empty() || kind == "socket" ? std::string() : line_for(path.data(), kind, file);
    const std::string_view name = kind == "segment" ? "sync" : kind == "cursor" ? "slot_sync" : "";
    return guarded(name, [&] {
        const auto result = static_cast<int>(::syscall(number, file));
        if (result == 0) add_to_log(line);
        return result;
    });
}

int open_with(int folder, const char* path, int flags, mode_t mode) {
    const bool creates = (flags & O_CREAT) != 0 && kind_of(path) == "segment";
    return guarded(creates ? "create" : "",
                   [&] { return static_cast<int>(::syscall(SYS_openat, folder, path, flags, mode)); });
}

/// Links FOLDER/JOURNAL/SEGMENT.
void keep_removed(std::string_view path) {
    static const char* const folder = std::getenv("TAKT_REMOVED");
    if (folder == nullptr) return;
    const auto journal = path.rfind('/', path.rfind('/') - 1);
    const auto kept = std::string(folder) + std::string(path.substr(journal));
    (void)::syscall(SYS_linkat, AT_FDCWD, std::string(path).c_str(), AT_FDCWD, kept.c_str(), 0);
}

mode_t mode_of(int flags, va_list arguments) {
    return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* time) noexcept {
    constexpr std::int64_t kSecond = 1'000'000'000;
    const auto result = static_cast<int>(::syscall(SYS_clock_gettime, clock, time));
    const auto offset = clock == CLOCK_REALTIME ? trouble().clock_offset_ns.load() : 0;
    if (result == 0 && offset != 0) {
        const auto ns = time->tv_sec * kSecond + time->tv_nsec + offset;
        *time = {.tv_sec = ns / kSecond, .tv_nsec = ns % kSecond};
    }
    return result;
}

ssize_t write(int file, const void* bytes, size_t size) {
    return write_to(file, size, [&](size_t part) { return ::syscall(SYS_write, file, bytes, part); });
}

ssize_t pwrite(int file, const void* bytes, size_t size, off_t offset) {
    return write_to(file, size,
                    [&](size_t part) { return ::syscall(SYS_pwrite64, file, bytes, part, offset); });
}

ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t offset) {
    return pwrite(file, bytes, size, offset);
}

ssize_t send(int file, const void* bytes, size_t size, int flags) {
    return write_to(file, size,
                    [&](size_t part) { return ::syscall(SYS_sendto, file, bytes, part, flags, nullptr, 0); });
}

ssize_t read(int file, void* bytes, size_t size) {
    Path path;
    const auto name = kind_of(file, path) == "socket" ? "receive" : "";
    return guarded(name, [&] { return ::syscall(SYS_read, file, bytes, size); });
}

ssize_t recv(int file, void* bytes, size_t size, int flags) {
    Path path;
    const auto name = kind_of(file, path) == "socket" ? "receive" : "";
    return guarded(name, [&] { return ::syscall(SYS_recvfrom, file, bytes, size, flags, nullptr, nullptr); });
}

int fdatasync(int file) {
    return sync_with(SYS_fdatasync, file);
}

int fsync(int file) {
    return sync_with(SYS_fsync, file);
}

int unlink(const char* path) noexcept {
    if (kind_of(path) == "segment") keep_removed(path);
    return guarded(kind_of(path) == "segment" ? "remove" : "",
                   [&] { return static_cast<int>(::syscall(SYS_unlink, path)); });
}

int open(const char* path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = mode_of(flags, arguments);
    va_end(arguments);
    return open_with(AT_FDCWD, path, flags, mode);
}

int open64(const char* path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = mode_of(flags, arguments);
    va_end(arguments);
    return open_with(AT_FDCWD, path, flags, mode);
}

}  // extern "C"
