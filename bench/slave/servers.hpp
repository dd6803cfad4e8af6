// The servers under test, each a process of its own on the second processor.
#pragma once

#include <sys/types.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace bench {

enum class Kind : std::uint8_t {
    takt,       ///< what `takt serve` runs: event loop, TCP server, slave engine, a blank device of ramps
    echo,       ///< for each request as many bytes as its answer has, unlooked at, in a bare epoll loop
    libmodbus,  ///< its own receive and reply, in an epoll loop
};
inline constexpr std::array kKinds{Kind::takt, Kind::echo, Kind::libmodbus};
std::string_view name(Kind kind);

/// Bytes of a request and of its answer, for the echo, which knows nothing else.
struct Sizes {
    std::size_t request = 12;
    std::size_t response = 11;
};

class ServerProcess {
public:
    ServerProcess(Kind kind, Sizes sizes);
    ~ServerProcess();
    ServerProcess(const ServerProcess&) = delete;
    ServerProcess& operator=(const ServerProcess&) = delete;

    [[nodiscard]] std::uint16_t port() const { return port_; }
    /// Memory of its own that it holds in RAM, in bytes.
    [[nodiscard]] std::size_t resident() const;
    /// Processor time it has used, in seconds.
    [[nodiscard]] double processor_s() const;

private:
    pid_t pid_ = -1;
    std::uint16_t port_ = 0;
};

/// Ties the calling thread to a processor, where there is one of that number.
void pin_to(unsigned processor);

/// As many descriptors as the system allows. @returns how many that are
std::size_t raise_descriptors();

}  // namespace bench
