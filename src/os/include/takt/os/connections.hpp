// What this computer is connected to: serial ports and networks.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace takt::os {

/// Serial ports with hardware, such as "/dev/ttyUSB0", in the order of their names.
/// @param tty  the class of the kernel
[[nodiscard]] std::vector<std::string> serial_ports(const std::string& tty = "/sys/class/tty");

/// The hosts of the network of an IPv4 address, such as "192.168.1.1-254": at most the 254 with the same
/// first three numbers.
/// @param mask  of a network with two hosts at least
[[nodiscard]] std::string host_range(std::uint32_t address, std::uint32_t mask);

/// The hosts of the IPv4 networks of this computer. Without the loopback network, point-to-point links, and
/// interfaces that are down.
[[nodiscard]] std::vector<std::string> host_ranges();

}  // namespace takt::os
