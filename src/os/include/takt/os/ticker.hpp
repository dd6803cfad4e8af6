// A thread that does the same work again and again.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace takt::os {

/// Calls a function on a thread of its own: at once, then each time a period after it returned, and a last
/// time at the end.
class Ticker {
public:
    using Turn = std::function<void(bool last)>;

    /// @param name  of the thread (name_thread())
    Ticker(const char* name, std::chrono::milliseconds period, Turn turn);
    /// Returns after the last turn. A second call does nothing. The owner's thread.
    void end();
    /// end()
    ~Ticker();
    Ticker(const Ticker&) = delete;
    Ticker& operator=(const Ticker&) = delete;

private:
    void work(const char* name);

    std::chrono::milliseconds period_;
    Turn turn_;
    std::mutex mutex_;
    std::condition_variable changed_;
    bool ended_ = false;  // guarded by mutex_
    std::thread thread_;
};

}  // namespace takt::os
