#include "takt/model/target_url.hpp"

#include <gtest/gtest.h>

namespace takt::model {
namespace target_url_test {

Line serial_line(wire::Framing framing, wire::CharacterFormat format, Rs485 rs485 = Rs485::automatic) {
    Line line;
    line.port = "/dev/ttyS1";
    line.framing = framing;
    line.format = format;
    line.rs485 = rs485;
    return line;
}

Line network_line(Transport transport, wire::Framing framing, std::string host, std::uint16_t port) {
    Line line;
    line.transport = transport;
    line.framing = framing;
    line.port = std::move(host);
    line.tcp_port = port;
    return line;
}

TEST(TargetUrl, NamesTheConnection) {
    using wire::Framing;
    using wire::Parity;
    const struct {
        Line line;
        const char* url;
    } cases[] = {
        {serial_line(Framing::rtu, {9600, 8, Parity::none, 2}),
         "rtu:///dev/ttyS1?baud=9600&parity=none&stop_bits=2"},
        {serial_line(Framing::ascii, {9600, 7, Parity::even, 1}),
         "ascii:///dev/ttyS1?baud=9600&parity=even&stop_bits=1&data_bits=7"},
        {serial_line(Framing::rtu, {9600, 8, Parity::odd, 1}, Rs485::rts),
         "rtu:///dev/ttyS1?baud=9600&parity=odd&stop_bits=1&rs485=rts"},
        {network_line(Transport::tcp, Framing::tcp, "host", 502), "tcp://host:502"},
        {network_line(Transport::tcp, Framing::rtu, "host", 4001), "rtu+tcp://host:4001"},
        {network_line(Transport::tls, Framing::tcp, "::1", 802), "tls://[::1]:802"},
    };
    for (const auto& [line, url] : cases) EXPECT_EQ(url_of(line), url);
}

TEST(TargetUrl, SettingsOfSerialLines) {
    using wire::Parity;
    EXPECT_EQ(settings_text(serial_line(wire::Framing::rtu, {19200, 8, Parity::even, 1})), "19200 8E1");
    EXPECT_EQ(settings_text(serial_line(wire::Framing::ascii, {1200, 7, Parity::none, 2})), "1200 7N2");
    EXPECT_EQ(settings_text(network_line(Transport::tcp, wire::Framing::tcp, "host", 502)), "");
}

TEST(TargetUrl, HostsWithTheirPort) {
    EXPECT_EQ(host_and_port("plc.local", 502), "plc.local:502");
    EXPECT_EQ(host_and_port("10.0.0.7", 1502), "10.0.0.7:1502");
    EXPECT_EQ(host_and_port("fe80::1%eth0", 502), "[fe80::1%eth0]:502");
}

TEST(TargetUrl, SettingsBehindAPort) {
    const struct {
        const char* text;
        const char* expected;
    } cases[] = {
        {"/dev/ttyUSB0,9600", "/dev/ttyUSB0?baud=9600"},
        {"/dev/ttyUSB0:9600,8E1", "/dev/ttyUSB0?baud=9600&data_bits=8&parity=even&stop_bits=1"},
        {"/dev/ttyUSB0 9600 8n2", "/dev/ttyUSB0?baud=9600&data_bits=8&parity=none&stop_bits=2"},
        {"/dev/ttyUSB0,9600,E,8", "/dev/ttyUSB0?baud=9600&parity=even&data_bits=8"},
        {"/dev/ttyUSB0@115200", "/dev/ttyUSB0?baud=115200"},
        {"/dev/ttyUSB0?baud=9600&parity=O", "/dev/ttyUSB0?baud=9600&parity=odd"},
        {"/dev/ttyUSB0,parity=чет", "/dev/ttyUSB0?parity=even"},
        {"rtu:///dev/ttyUSB0", "/dev/ttyUSB0?"},
        {"ascii:///dev/ttyUSB0?9600", "/dev/ttyUSB0?baud=9600"},
        {"COM3,9600", "COM3?baud=9600"},
        {"/dev/ttyUSB0", ""},
        {"/dev/ttyUSB0,", ""},
        {"/dev/ttyUSB0,fast", ""},
        {"/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0", ""},
        {"/dev/serial/by-id/usb-FTDI_FT232R_A9 600", "/dev/serial/by-id/usb-FTDI_FT232R_A9?baud=600"},
        {"/tmp/my port", ""},
        {"10.0.0.5:502", ""},
        {"tcp://plc:502", ""},
        {"", ""},
    };
    for (const auto& [text, expected] : cases) {
        const auto found = port_settings(text);
        EXPECT_EQ(found ? found->port + '?' + found->joined("=", "&") : "", expected) << text;
    }
}

}  // namespace target_url_test
}  // namespace takt::model
