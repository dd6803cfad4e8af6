// Preloaded (LD_PRELOAD) into `takt`: calls that wait for a disk or a name server wait for ever.
//
//   TAKT_STALL_FILE  while this file exists, fsync() and fdatasync() of a database or a segment do not return
//   TAKT_STALL_NAME  getaddrinfo() of this name does not return
#include <netdb.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include <dlfcn.h>

namespace {

bool is_stalled(int file) {
    const char* const mark = std::getenv("TAKT_STALL_FILE");
    if (mark == nullptr || ::access(mark, F_OK) != 0) return false;
    std::array<char, 40> link{};
    std::array<char, 4096> path{};
    (void)std::snprintf(link.data(), link.size(), "/proc/self/fd/%d", file);
    if (::readlink(link.data(), path.data(), path.size() - 1) <= 0) return false;
    const std::string_view name(path.data());
    return name.find(".history.db") != std::string_view::npos ||
           name.find("/segment-") != std::string_view::npos;
}

int sync_with(long number, int file) {
    while (is_stalled(file)) ::usleep(10'000);
    return static_cast<int>(::syscall(number, file));
}

}  // namespace

extern "C" {

int fsync(int file) {
    return sync_with(SYS_fsync, file);
}

int fdatasync(int file) {
    return sync_with(SYS_fdatasync, file);
}

int getaddrinfo(const char* node, const char* service, const addrinfo* hints, addrinfo** result) {
    const char* const stalled = std::getenv("TAKT_STALL_NAME");
    const bool asks = hints == nullptr || (hints->ai_flags & AI_NUMERICHOST) == 0;
    while (asks && stalled != nullptr && node != nullptr && std::strcmp(node, stalled) == 0) ::usleep(10'000);
    using Function = int (*)(const char*, const char*, const addrinfo*, addrinfo**);
    static const auto original = reinterpret_cast<Function>(::dlsym(RTLD_NEXT, "getaddrinfo"));
    return original(node, service, hints, result);
}

}  // extern "C"
