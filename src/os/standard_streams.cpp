#include "takt/os/standard_streams.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

namespace takt::os {

// The lower numbers are in use by then, so open() returns exactly the missing one.
void open_standard_streams() {
    for (const int number : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        if (::fcntl(number, F_GETFD) >= 0 || errno != EBADF) continue;
        (void)::open("/dev/null", number == STDIN_FILENO ? O_RDONLY : O_WRONLY);
    }
}

}  // namespace takt::os
