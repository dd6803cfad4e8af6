#include "takt/line/target.hpp"

#include <gtest/gtest.h>

#include "localhost.hpp"

namespace takt::line {
namespace target_test {

using model::Rs485;
using model::Transport;
using wire::Framing;
using wire::Parity;

TEST(Target, ReadsNetworkTargets) {
    struct Row {
        const char* url;
        Transport transport;
        Framing framing;
        const char* host;
        int port;
    };
    constexpr Row kRows[] = {
        {"tcp://plc", Transport::tcp, Framing::tcp, "plc", 502},
        {"tcp://plc:1502", Transport::tcp, Framing::tcp, "plc", 1502},
        {"tcp://10.0.0.5:65535", Transport::tcp, Framing::tcp, "10.0.0.5", 65535},
        {"tcp://plc.example:1/", Transport::tcp, Framing::tcp, "plc.example", 1},
        {"tcp://[::1]:502", Transport::tcp, Framing::tcp, "::1", 502},
        {"tcp://[fe80::1%eth0]", Transport::tcp, Framing::tcp, "fe80::1%eth0", 502},
        {"tls://plc", Transport::tls, Framing::tcp, "plc", 802},
        {"rtu+tcp://plc:4001", Transport::tcp, Framing::rtu, "plc", 4001},
    };
    for (const Row& row : kRows) {
        const auto target = parse_target(row.url);
        ASSERT_TRUE(target) << row.url;
        EXPECT_EQ(target->transport, row.transport) << row.url;
        EXPECT_EQ(target->framing, row.framing) << row.url;
        EXPECT_EQ(target->port, row.host) << row.url;
        EXPECT_EQ(target->tcp_port, row.port) << row.url;
        EXPECT_EQ(target->format.baud, 0u) << row.url << ": a byte stream has no character times";
    }
}

TEST(Target, ReadsSerialTargets) {
    struct Row {
        const char* url;
        Framing framing;
        wire::CharacterFormat format;
        Rs485 rs485;
    };
    constexpr Row kRows[] = {
        {"rtu:///dev/ttyUSB0", Framing::rtu, {19200, 8, Parity::even, 1}, Rs485::automatic},
        {"ascii:///dev/ttyUSB0", Framing::ascii, {19200, 7, Parity::even, 1}, Rs485::automatic},
        {"rtu:///dev/ttyUSB0?", Framing::rtu, {19200, 8, Parity::even, 1}, Rs485::automatic},
        {"rtu:///dev/ttyUSB0?baud=115200&parity=none&stop_bits=2&data_bits=8&rs485=rts",
         Framing::rtu,
         {115200, 8, Parity::none, 2},
         Rs485::rts},
        {"ascii:///dev/ttyUSB0?data_bits=8&parity=odd&rs485=kernel&baud=250000",
         Framing::ascii,
         {250000, 8, Parity::odd, 1},
         Rs485::kernel},
        {"rtu:///dev/ttyUSB0?rs485=none", Framing::rtu, {19200, 8, Parity::even, 1}, Rs485::none},
    };
    for (const Row& row : kRows) {
        const auto target = parse_target(row.url);
        ASSERT_TRUE(target) << row.url;
        EXPECT_EQ(target->transport, Transport::serial) << row.url;
        EXPECT_EQ(target->framing, row.framing) << row.url;
        EXPECT_EQ(target->port, "/dev/ttyUSB0") << row.url;
        EXPECT_EQ(target->format, row.format) << row.url;
        EXPECT_EQ(target->rs485, row.rs485) << row.url;
    }
}

TEST(Target, NamesThePartThatIsWrong) {
    struct Row {
        const char* url;
        Code code;
        const char* subject;
    };
    constexpr Row kRows[] = {
        // no scheme: the right form is shown
        {"10.0.0.5:502", Code::syntax, "10.0.0.5:502 → tcp://10.0.0.5:502"},
        {"plc", Code::syntax, "plc → tcp://plc"},
        {"::1", Code::syntax, "::1 → tcp://[::1]"},
        {"[::1]:502", Code::syntax, "[::1]:502 → tcp://[::1]:502"},
        {"/dev/ttyUSB0", Code::syntax, "/dev/ttyUSB0 → rtu:///dev/ttyUSB0"},
        {"", Code::syntax, " → tcp://host:502, rtu:///dev/ttyUSB0"},
        {"what is this", Code::syntax, "what is this → tcp://host:502, rtu:///dev/ttyUSB0"},
        {"tpc://plc", Code::syntax, "tpc://plc → tcp://plc"},
        {"rtuovertcp://plc:4001", Code::syntax, "rtuovertcp://plc:4001 → rtu+tcp://plc:4001"},
        {"rtu+tpc://plc", Code::syntax, "rtu+tpc://plc → rtu+tcp://plc"},
        {"rtu:///dev/ttyS0?buad=9600", Code::syntax, "buad=9600 → baud=9600"},
        {"rtu:///dev/ttyS0?parity=evn", Code::syntax, "parity=evn → parity=even"},
        {"udp://plc", Code::syntax, "udp://plc → tcp, tls, rtu+tcp, rtu, ascii"},
        // host and port
        {"tcp://", Code::syntax, " → host:502"},
        {"tcp://:502", Code::syntax, ":502 → host:502"},
        {"tcp://pl c", Code::syntax, "pl c → host:502"},
        {"tcp://::1", Code::syntax, "::1 → [::1]"},
        {"tcp://[::1", Code::syntax, "[::1 → [::1]:502"},
        {"tcp://[plc]", Code::syntax, "[plc] → [::1]:502"},
        {"tcp://[::1]x", Code::syntax, "x → :502"},
        {"tcp://plc:", Code::syntax, "port= → 1..65535"},
        {"tcp://plc:x", Code::syntax, "port=x → 1..65535"},
        {"tcp://plc:+5", Code::syntax, "port=+5 → 1..65535"},
        {"tcp://plc:99999999999999999999", Code::syntax, "port=99999999999999999999 → 1..65535"},
        {"tcp://plc:0", Code::out_of_range, "port"},
        {"tcp://plc:65536", Code::out_of_range, "port"},
        {"tcp://plc/path", Code::syntax, "/path → tcp://plc"},
        {"tcp:///10.0.0.1", Code::syntax, "/10.0.0.1 → tcp://10.0.0.1"},
        {"tcp:///dev/ttyUSB0", Code::syntax, "/dev/ttyUSB0 → rtu:///dev/ttyUSB0"},
        {"tcp://me@plc", Code::syntax, "@plc → tcp://plc"},
        {"tcp://plc?baud=9600", Code::syntax, "?baud=9600 → tcp://plc"},
        // serial ports
        {"rtu://", Code::syntax, "rtu:// → rtu:///dev/ttyUSB0"},
        {"rtu://ttyUSB0", Code::syntax, "ttyUSB0 → rtu:///dev/ttyUSB0"},
        {"ascii://ttyUSB0", Code::syntax, "ttyUSB0 → ascii:///dev/ttyUSB0"},
        {"rtu://dev/ttyUSB0?baud=9600", Code::syntax, "dev/ttyUSB0 → rtu:///dev/ttyUSB0?baud=9600"},
        {"rtu://10.0.0.1:4001", Code::syntax, "rtu://10.0.0.1:4001 → rtu+tcp://10.0.0.1:4001"},
        {"rtu:///dev/ttyS0?bauds=9600", Code::syntax, "bauds=9600 → baud=9600"},
        {"rtu:///dev/ttyS0?x=1", Code::syntax, "x=1 → baud, parity, stop_bits, data_bits, rs485"},
        {"rtu:///dev/ttyS0?baud", Code::syntax, "baud → baud, parity, stop_bits, data_bits, rs485"},
        {"rtu:///dev/ttyS0?baud=fast", Code::syntax, "baud=fast → 50..4000000"},
        {"rtu:///dev/ttyS0?baud=", Code::syntax, "baud= → 50..4000000"},
        {"rtu:///dev/ttyS0?baud=49", Code::out_of_range, "baud"},
        {"rtu:///dev/ttyS0?parity=mark", Code::syntax, "parity=mark → none, even, odd"},
        {"rtu:///dev/ttyS0?stop_bits=3", Code::out_of_range, "stop_bits"},
        {"rtu:///dev/ttyS0?data_bits=7", Code::out_of_range, "data_bits"},
        {"ascii:///dev/ttyS0?data_bits=6", Code::out_of_range, "data_bits"},
        {"rtu:///dev/ttyS0?parity=E", Code::syntax, "parity=E → parity=even"},
        {"rtu:///dev/ttyS0&parity=E", Code::syntax, "&parity=E → rtu:///dev/ttyS0?parity=even"},
        {"parity=E", Code::syntax, "parity=E → rtu:///dev/ttyUSB0?parity=even"},
        {"rtu:///dev/ttyS0?unit=3", Code::syntax, "unit=3 → --unit 3"},
        {"tcp://plc?unit=3", Code::syntax, "?unit=3 → tcp://plc --unit 3"},
        {"tcp://@", Code::syntax, "@ → tcp://host:502"},
        {"com3", Code::syntax, "com3 → rtu:///dev/ttyUSB0, rtu:///dev/ttyS2"},
        {"rtu://COM1", Code::syntax, "COM1 → rtu:///dev/ttyUSB0, rtu:///dev/ttyS0"},
        {"ttyUSB1", Code::syntax, "ttyUSB1 → rtu:///dev/ttyUSB1"},
        {"dev/ttyUSB1", Code::syntax, "dev/ttyUSB1 → rtu:///dev/ttyUSB1"},
        // separators of other tools
        {"/dev/ttyUSB0,9600", Code::syntax, "/dev/ttyUSB0,9600 → rtu:///dev/ttyUSB0?baud=9600"},
        {"rtu:///dev/ttyUSB0,9600", Code::syntax, ",9600 → rtu:///dev/ttyUSB0?baud=9600"},
        {"rtu://ttyUSB0,9600", Code::syntax, "ttyUSB0,9600 → rtu:///dev/ttyUSB0?baud=9600"},
        {"ascii:///dev/ttyUSB0:9600", Code::syntax, ":9600 → ascii:///dev/ttyUSB0?baud=9600"},
        {"rtu:///dev/ttyUSB0?9600", Code::syntax, "9600 → rtu:///dev/ttyUSB0?baud=9600"},
        {"ttyS1 9600 7O1", Code::syntax,
         "ttyS1 9600 7O1 → rtu:///dev/ttyS1?baud=9600&data_bits=7&parity=odd&stop_bits=1"},
        {"COM3,9600", Code::syntax, "COM3,9600 → rtu:///dev/ttyUSB0?baud=9600, rtu:///dev/ttyS2?baud=9600"},
        {"tcp//plc", Code::syntax, "tcp//plc → tcp://plc"},
        {"tcp:/plc:1502", Code::syntax, "tcp:/plc:1502 → tcp://plc:1502"},
        {"tcp:plc", Code::syntax, "tcp:plc → tcp://plc"},
        {"tcp;\\\\plc", Code::syntax, "tcp;\\\\plc → tcp://plc"},
        {"tcp:502", Code::syntax, "tcp:502 → tcp://host:502"},
        {"rtu:9600", Code::syntax, "rtu:9600 → rtu:///dev/ttyUSB0?baud=9600"},
        {"rtu//10.0.0.1:4001", Code::syntax, "rtu//10.0.0.1:4001 → rtu+tcp://10.0.0.1:4001"},
        {"tcp.plc", Code::syntax, "tcp.plc → tcp://tcp.plc"},
        {"rtu+tcp:/plc", Code::syntax, "rtu+tcp:/plc → rtu+tcp://plc"},
        {"rtu:/dev/ttyUSB0", Code::syntax, "rtu:/dev/ttyUSB0 → rtu:///dev/ttyUSB0"},
        {"ascii:ttyUSB0,9600", Code::syntax, "ascii:ttyUSB0,9600 → ascii:///dev/ttyUSB0?baud=9600"},
        {"rtu:plc", Code::syntax, "rtu:plc → tcp://host:502, rtu:///dev/ttyUSB0"},
        {"rtu:///dev/ttyS0?rs485=yes", Code::syntax, "rs485=yes → auto, kernel, rts, none"},
    };
    for (const Row& row : kRows) {
        const auto target = parse_target(row.url);
        ASSERT_FALSE(target) << row.url;
        EXPECT_EQ(target.error().code, row.code) << row.url;
        EXPECT_EQ(target.error().subject.view(), row.subject) << row.url;
    }
    EXPECT_EQ(parse_target("tcp://plc:65536").error().numbers,
              (std::array<std::int64_t, 3>{65536, 1, 65535}));
    EXPECT_EQ(parse_target("rtu:///d?data_bits=7").error().numbers, (std::array<std::int64_t, 3>{7, 8, 8}));
}

TEST(Target, BoundsWhatItRepeats) {
    const auto target = parse_target("rtu:///dev/ttyS0?" + std::string(100'000, 'x'));
    ASSERT_FALSE(target);
    EXPECT_TRUE(target.error().subject.view().ends_with("rs485")) << "the advice is not cut off";
}

TEST(Target, BecomesALine) {
    const auto serial = parse_target("ascii:///dev/ttyS1?baud=9600").value().as_line();
    EXPECT_EQ(serial.name, "/dev/ttyS1");
    EXPECT_EQ(serial.framing, Framing::ascii);
    EXPECT_EQ(serial.format.baud, 9600u);
    EXPECT_TRUE(serial.is_serial());
    EXPECT_EQ(parse_target("tcp://[::1]").value().as_line().name, "[::1]:502");
}

TEST(Listen, ReadsAddresses) {
    struct Row {
        const char* text;
        const char* host;
        int port;
    };
    constexpr Row kRows[] = {
        {"127.0.0.1:1502", "127.0.0.1", 1502},
        {"tcp://127.0.0.1", "127.0.0.1", 502},
        {"[::1]:0", "::1", 0},
        {":1502", "", 1502},
        {"*:502", "", 502},
    };
    for (const Row& row : kRows) {
        const auto address = parse_listen(row.text);
        ASSERT_TRUE(address) << row.text;
        EXPECT_EQ(address->host, row.host) << row.text;
        EXPECT_EQ(address->port, row.port) << row.text;
    }
    for (const char* wrong :
         {"", "plc:502", "1502x", "127.0.0.1:65536", "::1:502:x", "[::1", "ssl://127.0.0.1"})
        EXPECT_FALSE(parse_listen(wrong)) << wrong;
}

TEST(Listen, TlsHasCertificatesOfAFolder) {
    EXPECT_EQ(parse_listen("127.0.0.1:502")->certificates, std::nullopt);
    const auto usual = parse_listen("tls://127.0.0.1");
    EXPECT_EQ(usual->port, 802);
    EXPECT_EQ(usual->certificates, "certs/");
    EXPECT_EQ(parse_listen("tls://*:8802?certs=/etc/takt")->certificates, "/etc/takt/");
}

TEST(Targets, TlsHasCertificatesOfAFolder) {
    EXPECT_EQ(parse_target("tls://plc")->as_line().tls, model::files_in("certs/", "client"));
    EXPECT_EQ(parse_target("tls://plc:8802?certs=plant")->as_line().tls, model::files_in("plant/", "client"));
    EXPECT_FALSE(parse_target("tcp://plc?certs=plant"));
}

TEST(Listen, TakesANameOfThisMachine) {
    if (!localhost_resolves()) GTEST_SKIP() << kNoLocalhost;
    const auto address = parse_listen("localhost:1502");
    ASSERT_TRUE(address);
    EXPECT_EQ(address->host, "127.0.0.1");
    EXPECT_EQ(address->port, 1502);
}

}  // namespace target_test
}  // namespace takt::line
