// Work that competes with the thread that is measured.
#pragma once

#include <atomic>
#include <thread>
#include <vector>

namespace takt::client {

/// While it lives, each of its threads computes, and writes more memory than the caches hold.
class BackgroundLoad {
public:
    /// @param threads  one for each processor loads all of them
    /// @throws std::system_error when a thread cannot be started; then none remains
    explicit BackgroundLoad(unsigned threads);
    ~BackgroundLoad();
    BackgroundLoad(const BackgroundLoad&) = delete;
    BackgroundLoad& operator=(const BackgroundLoad&) = delete;

private:
    void work() const;
    void end();

    std::atomic<bool> ended_ = false;
    std::vector<std::thread> threads_;
};

}  // namespace takt::client
