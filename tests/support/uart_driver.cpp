// Preloaded (LD_PRELOAD) into `takt`: a pseudo-terminal looks like a port of a UART driver. TAKT_UART is the
// behaviour of this driver when ASYNC_LOW_LATENCY is set: `accepts`, `ignores` (no error, and the flag is not
// set), `refuses` (EPERM) or `lacks` (ENOTTY: no TIOCGSERIAL).
#include <asm/termbits.h>
#include <dlfcn.h>
#include <linux/serial.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <cerrno>
#include <cstdarg>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace {

serial_struct settings;
tcflag_t format;  // a pseudo-terminal drops the parity

template <class Function>
Function* libc(const char* name) {
    return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

int fail(int error) {
    errno = error;
    return -1;
}

int as_uart(int result, struct stat* status) {
    const bool pseudo = result == 0 && major(status->st_rdev) >= 136 && major(status->st_rdev) <= 143;
    if (pseudo) status->st_rdev = makedev(4, 65);
    return result;
}

int set_serial(std::string_view driver, const serial_struct& wanted) {
    if (driver == "refuses") return fail(EPERM);
    if (driver == "accepts") settings = wanted;
    return 0;
}

}  // namespace

extern "C" {

int fstat(int fd, struct stat* status) noexcept {
    return as_uart(libc<int(int, struct stat*)>("fstat")(fd, status), status);
}

int stat(const char* path, struct stat* status) noexcept {
    return as_uart(libc<int(const char*, struct stat*)>("stat")(path, status), status);
}

int ioctl(int fd, unsigned long request, ...) noexcept {
    std::va_list arguments;
    va_start(arguments, request);
    void* const argument = va_arg(arguments, void*);
    va_end(arguments);
    const char* const driver = std::getenv("TAKT_UART");
    if (request != TIOCGSERIAL && request != TIOCSSERIAL) {
        auto* const termios = static_cast<termios2*>(argument);
        if (request == TCSETS2) format = termios->c_cflag;
        const int result = libc<int(int, unsigned long, ...)>("ioctl")(fd, request, argument);
        if (request == TCGETS2 && format != 0) termios->c_cflag = format;
        return result;
    }
    if (std::string_view(driver) == "lacks") return fail(ENOTTY);
    if (request == TIOCSSERIAL) return set_serial(driver, *static_cast<serial_struct*>(argument));
    std::memcpy(argument, &settings, sizeof settings);
    return 0;
}
}
