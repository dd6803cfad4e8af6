// One turn of an event loop, for tests that drive it by hand.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <memory>

#include "takt/line/loop.hpp"

namespace takt::test {

/// Handles the events that are ready, the timers that are due and the posted tasks, and waits for nothing.
/// @param turns  more than one where an event causes another
inline void turn(line::Loop& loop, int turns = 1) {
    for (; turns > 0 && !loop.stopped(); --turns) {
        const auto done = std::make_shared<bool>(false);
        loop.post([done] { *done = true; });
        const bool ended = loop.run_until([&done] { return *done; }, std::chrono::seconds(30));
        ASSERT_TRUE(ended || loop.stopped());
    }
}

}  // namespace takt::test
