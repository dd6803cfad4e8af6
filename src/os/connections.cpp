#include "takt/os/connections.hpp"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <system_error>

namespace takt::os {
namespace {

// The kernel has entries for ports of the first type that are not there.
bool has_hardware(const std::filesystem::path& port) {
    std::error_code failed;
    if (!std::filesystem::exists(port / "device", failed)) return false;
    std::string type;
    std::ifstream(port / "type") >> type;
    return type != "0";
}

bool is_network(const ifaddrs& its) {
    constexpr unsigned kNeeded = IFF_UP | IFF_BROADCAST;
    return its.ifa_addr != nullptr && its.ifa_netmask != nullptr && its.ifa_addr->sa_family == AF_INET &&
           (its.ifa_flags & kNeeded) == kNeeded && (its.ifa_flags & IFF_LOOPBACK) == 0;
}

std::uint32_t number_of(const sockaddr* address) {
    return ntohl(reinterpret_cast<const sockaddr_in*>(address)->sin_addr.s_addr);
}

}  // namespace

std::string host_range(std::uint32_t address, std::uint32_t mask) {
    constexpr std::uint32_t kLastNumber = 0xff;
    const std::uint32_t hosts = std::min(~mask, kLastNumber);
    const std::uint32_t network = address & ~hosts;
    std::string text;
    for (const unsigned shift : {24U, 16U, 8U}) text += std::to_string(network >> shift & kLastNumber) + '.';
    const std::uint32_t first = network & kLastNumber;
    return text + std::to_string(first + 1) + '-' + std::to_string(first + hosts - 1);
}

std::vector<std::string> serial_ports(const std::string& tty) {
    std::vector<std::string> ports;
    std::error_code failed;
    for (const auto& entry : std::filesystem::directory_iterator(tty, failed))
        if (has_hardware(entry.path())) ports.push_back("/dev/" + entry.path().filename().string());
    std::ranges::sort(ports);
    return ports;
}

std::vector<std::string> host_ranges() {
    ifaddrs* list = nullptr;
    if (getifaddrs(&list) != 0) return {};
    const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner(list, freeifaddrs);
    std::vector<std::string> ranges;
    for (const auto* its = list; its != nullptr; its = its->ifa_next) {
        if (!is_network(*its)) continue;
        constexpr std::uint32_t kPair = 1;  // of a link with two ends
        const auto mask = number_of(its->ifa_netmask);
        if (~mask > kPair) ranges.push_back(host_range(number_of(its->ifa_addr), mask));
    }
    std::ranges::sort(ranges);
    const auto same = std::ranges::unique(ranges);
    ranges.erase(same.begin(), same.end());
    return ranges;
}

}  // namespace takt::os
