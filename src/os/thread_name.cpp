#include "takt/os/thread_name.hpp"

#include <pthread.h>

namespace takt::os {

void name_thread(const char* name) {
    (void)::pthread_setname_np(::pthread_self(), name);
}

}  // namespace takt::os
