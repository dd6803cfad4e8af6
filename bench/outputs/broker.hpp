// A mosquitto of the benchmark, on a free port of the loopback interface.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "../working_folder.hpp"

namespace takt::bench {

/// Without persistence and without limits for its subscribers. It does not run before start().
class Broker {
public:
    explicit Broker(const WorkingFolder& folder);
    ~Broker();
    Broker(const Broker&) = delete;
    Broker& operator=(const Broker&) = delete;

    /// Returns when it listens. Throws Failure.
    void start();
    void kill();

    /// From now on it works 5 of each 100 ms: it reads and acknowledges slowly.
    void slow_down();
    /// It reads nothing; its connections stay open.
    void freeze();
    /// Ends slow_down() and freeze().
    void wake();

    [[nodiscard]] std::uint16_t port() const { return port_; }

private:
    void send(int signal) const;

    const WorkingFolder& folder_;
    std::uint16_t port_;
    pid_t process_ = -1;
    std::atomic<bool> slow_ = false;
    std::thread brake_;
};

/// A port that nothing listens on.
[[nodiscard]] std::uint16_t free_port();

}  // namespace takt::bench
