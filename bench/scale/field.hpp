// A field of Modbus TCP devices in processes of their own: one loopback address each, one port for all.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace takt::bench {

/// The address of a device: 127.1.0.1 and on.
std::string device_address(std::size_t device);

/// Binds the calling process to one processor; without effect where there is no such processor.
void pin_to_processor(int processor);

/// The memory that the processes share.
struct FieldState {
    std::atomic<std::uint64_t> requests;
    std::atomic<std::uint64_t> connections;  ///< accepted so far
    std::atomic<std::uint32_t> drops;        ///< raised by the master: close all connections now
    std::atomic<std::uint64_t> listening;    ///< devices
    std::atomic<std::uint16_t> port;
    std::atomic<bool> failed;
};

/// Answers 0x03 and 0x04 with registers that change from request to request. As many processes as the limit
/// of descriptors demands.
class Field {
public:
    /// Forks; the devices listen when it returns.
    Field(std::size_t devices, int processor);
    ~Field();
    Field(const Field&) = delete;
    Field& operator=(const Field&) = delete;

    [[nodiscard]] bool ok() const { return !state_->failed; }
    [[nodiscard]] std::uint16_t port() const { return state_->port; }
    [[nodiscard]] std::uint64_t requests() const { return state_->requests; }
    [[nodiscard]] std::uint64_t connections() const { return state_->connections; }
    /// As a switch that restarts: every connection is reset.
    void drop_all() { ++state_->drops; }

private:
    void start(std::size_t first, std::size_t end, int processor);

    FieldState* state_;
    std::vector<pid_t> processes_;
};

}  // namespace takt::bench
