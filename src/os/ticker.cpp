#include "takt/os/ticker.hpp"

#include <utility>

#include "takt/os/thread_name.hpp"

namespace takt::os {

Ticker::Ticker(const char* name, std::chrono::milliseconds period, Turn turn)
    : period_(period), turn_(std::move(turn)), thread_([this, name] { work(name); }) {}

Ticker::~Ticker() {
    end();
}

void Ticker::end() {
    {
        const std::lock_guard lock(mutex_);
        ended_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
}

void Ticker::work(const char* name) {
    name_thread(name);
    for (bool last = false;;) {
        turn_(last);
        if (last) return;
        std::unique_lock lock(mutex_);
        last = changed_.wait_for(lock, period_, [this] { return ended_; });
    }
}

}  // namespace takt::os
