#include "takt/os/connections.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "folder.hpp"

namespace takt::os {
namespace connections_test {

TEST(Connections, ListsSerialPortsWithHardware) {
    const test::Folder tty;
    tty.write("tty0/dev", "4:0");
    for (const auto* const port : {"ttyS0", "ttyS1", "ttyUSB1", "ttyUSB0"})
        tty.write(std::string(port) + "/device/uevent", "");
    tty.write("ttyS0/type", "4\n");
    tty.write("ttyS1/type", "0\n");
    EXPECT_EQ(serial_ports(tty.path()),
              (std::vector<std::string>{"/dev/ttyS0", "/dev/ttyUSB0", "/dev/ttyUSB1"}));
    EXPECT_EQ(serial_ports(tty / "none"), std::vector<std::string>{});
}

TEST(Connections, HostsOfANetworkAreARange) {
    constexpr std::uint32_t kAddress = 0xc0a80115;  // 192.168.1.21
    EXPECT_EQ(host_range(kAddress, 0xffffff00), "192.168.1.1-254");
    EXPECT_EQ(host_range(kAddress, 0xfffffff0), "192.168.1.17-30");
    EXPECT_EQ(host_range(kAddress, 0xffff0000), "192.168.1.1-254");
    for (const auto& range : host_ranges()) EXPECT_FALSE(range.starts_with("127.")) << range;
}

}  // namespace connections_test
}  // namespace takt::os
