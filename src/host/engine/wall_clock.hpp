// The time of day, for results that are kept longer than the program runs.
#pragma once

#include <chrono>

namespace takt::host {

inline std::chrono::sys_seconds wall_now() {
    return std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
}

}  // namespace takt::host
