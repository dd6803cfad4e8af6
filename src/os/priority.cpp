// On Linux the nice value belongs to the thread: setpriority(2), "C library/kernel differences".
#include "takt/os/priority.hpp"

#include <sys/resource.h>

namespace takt::os {

void become_background_thread() {
    const int before = ::getpriority(PRIO_PROCESS, 0);
    (void)::setpriority(PRIO_PROCESS, 0, before + kBackgroundNice);
}

}  // namespace takt::os
