#include "takt/os/descriptor.hpp"

#include <unistd.h>

namespace takt::os {

void Descriptor::reset(int number) {
    const int old = std::exchange(number_, number);
    if (old >= 0) ::close(old);
}

}  // namespace takt::os
