#include "takt/os/priority.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <thread>

namespace takt::os {
namespace priority_test {

int nice_value() {
    return ::getpriority(PRIO_PROCESS, 0);
}

TEST(Priority, ABackgroundThreadAndItsThreadsGetLess) {
    constexpr int kMost = 19;  // of Linux
    const int before = nice_value();
    int of_thread = 0;
    int of_its_thread = 0;
    std::thread([&] {
        become_background_thread();
        of_thread = nice_value();
        std::thread([&] { of_its_thread = nice_value(); }).join();
    }).join();
    EXPECT_EQ(of_thread, std::min(before + kBackgroundNice, kMost));
    EXPECT_EQ(of_its_thread, of_thread);
    EXPECT_EQ(nice_value(), before);
}

}  // namespace priority_test
}  // namespace takt::os
