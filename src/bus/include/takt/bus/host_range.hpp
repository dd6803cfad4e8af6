// Ranges of IPv4 hosts in the URL of a target.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/result.hpp"

namespace takt::bus {

/// Most ports and hosts of one scan.
inline constexpr std::size_t kMaxScanTargets = 4096;

/// IPv4 addresses as numbers, both ends included.
struct HostRange {
    std::uint32_t first = 0;
    std::uint32_t last = 0;

    [[nodiscard]] std::uint64_t size() const { return std::uint64_t{last} - first + 1; }
    friend bool operator==(const HostRange&, const HostRange&) = default;
};

/// "10.0.0.1".
[[nodiscard]] std::string ipv4_text(std::uint32_t address);

/// Reads "10.0.0.1-20", "10.0.0.1-10.0.1.20" and "10.0.0.0/24". A network comes without its first and last
/// address, which no host has. Any other text is one host: nothing.
/// @returns syntax ("TEXT → an example"), out_of_range (text, hosts, 1, kMaxScanTargets)
[[nodiscard]] Result<std::optional<HostRange>> parse_host_range(std::string_view host);

/// A URL whose host is a range, and the URL of its first host.
struct UrlRange {
    HostRange hosts;
    std::string first_url;
};

/// Reads the host of "tcp://10.0.0.1-20:502"; nothing where the URL names one host or a serial port.
/// @returns the errors of parse_host_range()
[[nodiscard]] Result<std::optional<UrlRange>> parse_url_range(std::string_view url);

}  // namespace takt::bus
