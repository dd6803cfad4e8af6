// Noise of a line driver or adapter before the responses of a device.
#pragma once

#include <cstdint>

namespace takt::poll {

/// Bytes that were received between a request and its response, and are no frame.
struct NoiseFinding {
    std::uint32_t least = 0;  ///< bytes before one response
    std::uint32_t most = 0;
    friend bool operator==(const NoiseFinding&, const NoiseFinding&) = default;
};

}  // namespace takt::poll
