// A `set` whose answer waits: until it is on the disk, until it is written, or both.
#pragma once

#include "takt/app/running.hpp"

namespace takt::app {

struct Running::WaitingSet {
    Answer answer;
    Reply reply;
    Hearer hearer = Hearer::asker;
    Instant until = kNever;  ///< longest wait for its being written
    int parts = 1;           ///< what it still waits for

    /// One of them is done: the last one answers.
    void part_done() {
        if (--parts == 0) reply(answer);
    }
};

}  // namespace takt::app
