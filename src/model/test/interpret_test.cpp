#include <gtest/gtest.h>

#include <string>

#include "findings_text.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/findings.hpp"
#include "takt/model/firmware.hpp"

namespace takt::model::test {
namespace interpret_test {

using namespace std::chrono_literals;

TEST(Interpret, AProjectWithoutMistakes) {
    const auto checked = interpret(document({}));
    EXPECT_EQ(findings_text(checked), "");
    EXPECT_FALSE(checked.has_errors());
    const auto& line = checked.project.lines.at(0);
    EXPECT_EQ(line.name, "N");
    EXPECT_EQ(line.port, "/dev/ttyS0");
    EXPECT_EQ(line.framing, wire::Framing::rtu);
    EXPECT_EQ(line.format, (wire::CharacterFormat{19200, 8, wire::Parity::even, 1}));
    EXPECT_EQ(line.order, PollOrder::deadline);
    EXPECT_EQ(line.request_gap, 0ns);
    const auto& device = line.devices.at(0);
    EXPECT_EQ(device.address, UnitId{16});
    EXPECT_EQ(device.poll_period, 1s);
    EXPECT_EQ(device.response_timeout, 500ms);
    EXPECT_EQ(device.turnaround, std::nullopt);
    EXPECT_EQ(device.attempts, 3);
    EXPECT_TRUE(device.group_requests);
    EXPECT_EQ(device.registers_per_request, 16);
    EXPECT_EQ(device.strategy, Strategy::optimal);
    EXPECT_EQ(device.gaps, Gaps::never);
    EXPECT_EQ(device.order, (ByteOrder{true, false}));
    const auto& variable = device.variables.at(0);
    EXPECT_EQ(variable.type, DataType::int16);
    EXPECT_EQ(variable.area, wire::Area::holding_register);
    EXPECT_EQ(variable.read, wire::Function::read_holding_registers);
    EXPECT_EQ(variable.write, std::nullopt);
    EXPECT_EQ(variable.period, 1s);
    EXPECT_TRUE(variable.used);
    EXPECT_EQ(variable.start(), 0);
    EXPECT_EQ(variable.items(), 1);
}

TEST(Interpret, Project) {
    const Case cases[] = {
        {"{takt: ~}", "field.missing takt= [1]"},
        {"{takt: 2}", "project.version takt=2 [1]"},
        {"{takt: \"1\"}", "field.quoted_number takt=1 [1]"},
        {"{profile: owen}", "field.unknown_word profile=owen [generic, owen-kc1]"},
        {"{lines: ~}", "field.missing lines="},
        {"{lines: []}", "lines.none lines="},
        {"{lines: }", "field.empty lines="},
        {"{lines: many}", "field.not_a_list lines=many"},
        {"{lines: [5]}", "field.not_a_mapping lines[0]=5"},
        {"{locals: }", ""},
        {"{line: []}",
         "key.unknown line=line [takt, profile, derive_timeouts, timeout_margin, host, faults, backoff, "
         "lines, servers, instruments, locals, outputs]"},
        {"{baud: 9600}",
         "key.elsewhere baud=baud [takt, profile, derive_timeouts, timeout_margin, host, faults, backoff, "
         "lines, servers, instruments, locals, outputs]"},
        {"{derive_timeouts: off}", "boolean.malformed derive_timeouts=off [true, false]"},
        {"{timeout_margin: 5ms}", ""},
    };
    for (const auto& [keys, expected] : cases) EXPECT_EQ(findings_text({.project = keys}), expected) << keys;
}

TEST(Interpret, WhatIsNoProject) {
    EXPECT_EQ(findings_text(interpret({})), "document.empty =");
    EXPECT_EQ(findings_text(interpret({{"x"}, flow("[1, 2]")})), "document.not_a_project =");
    EXPECT_EQ(findings_text(interpret({{"x"}, flow("hello")})), "document.not_a_project =hello");
}

TEST(Interpret, Line) {
    const Case cases[] = {
        {"{name: ~}", "field.missing name="},
        {"{name: \"\"}", "field.length name= [1..128]"},
        {"{name: [a]}", "field.not_a_value name="},
        {"{transport: rs485}", "field.unknown_word transport=rs485 [serial, tcp, tls, simulated]"},
        {"{transport: modbus-tcp, host: plc, port: ~}",
         "field.unknown_word transport=modbus-tcp [serial, tcp, tls, simulated]"},
        {"{port: ~}", "line.port_missing port="},
        {"{port: ~, transport: simulated}", ""},
        {"{transport: tcp, host: plc, port: ~}", ""},
        {"{transport: ~, host: plc, port: ~}", ""},
        {"{transport: ~, host: plc, port: 502}", "line.port_number port=502"},
        {"{transport: tcp, host: plc, port: 502}", "line.port_number port=502"},
        {"{port: 502}", "line.port_number port=502"},
        {"{port: \"/dev/ttyUSB0,9600\"}", "line.port_settings port=/dev/ttyUSB0,9600"},
        {"{port: \"rtu:///dev/ttyUSB0\"}", "line.port_settings port=rtu:///dev/ttyUSB0"},
        {"{port: \"192.168.0.1:502\"}", "line.port_settings port=192.168.0.1:502"},
        {"{port: \"tcp://plc\"}", "line.port_settings port=tcp://plc"},
        {"{transport: tcp, host: plc, port: \"10.0.0.1\"}", "line.port_settings port=10.0.0.1"},
        {"{port: COM3}", "line.port_settings port=COM3"},
        {"{port: ttyUSB0}", "line.port_settings port=ttyUSB0"},
        {"{transport: simulated, port: 502}", ""},
        {"{transport: ~, ip: plc, port: ~}",
         "key.unknown ip=ip [name, transport, port, host, tcp_port, tls, framing, baud, parity, stop_bits, "
         "data_bits, rs485, order, request_gap, frame_gap, byte_timeout, connection, idle_close, "
         "pause_after_connect, connections_per_host, length_tolerance, relay_interval, command_interval, "
         "command_burst, devices]"},
        {"{transport: tcp, host: \"tcp://1.2.3.4\", port: ~}", "host.malformed host=tcp://1.2.3.4"},
        {"{transport: tcp, host: \"[::1]:502\", port: ~}", "host.malformed host=[::1]:502"},
        {"{transport: tcp, host: 192.168.1.10/24, port: ~}", "host.malformed host=192.168.1.10/24"},
        {"{transport: tcp, host: \"192,168,1,10\", port: ~}", "host.malformed host=192,168,1,10"},
        {"{transport: tcp, host: \"fe80::1%eth0\", port: ~}", ""},
        {"{transport: tcp, host: насос-1.local, port: ~}", ""},
        {"{request_gap: \"0,5ms\"}", "number.comma request_gap=0,5ms [0ms..65535ms]"},
        {"{transport: ~, host: plc}", "?field.without_effect host=plc"},
        {"{transport: tcp, host: plc, port: ~, framing: rtu}", ""},
        {"{transport: tcp, host: \"10.0.0.7:502\", port: ~}", "host.with_port host=10.0.0.7:502"},
        {"{transport: tcp, host: \"plc:1502\", port: ~}", "host.with_port host=plc:1502"},
        {"{transport: tcp, host: \"::1\", port: ~}", ""},
        {"{transport: tcp, host: \"fe80::1:502\", port: ~}", ""},
        {"{transport: tcp, host: 10.0.0.300, port: ~}", "host.no_address host=10.0.0.300"},
        {"{transport: tcp, host: 10.0.0, port: ~}", "host.no_address host=10.0.0"},
        {"{transport: tcp, host: 10.0.0.1., port: ~}", "host.no_address host=10.0.0.1."},
        {"{transport: tcp, host: 255.255.255.255, port: ~}", ""},
        {"{transport: tcp, host: plc7, port: ~}", ""},
        {"{transport: tls, host: plc, port: ~}", ""},
        {"{transport: tls, host: plc, port: ~, tls: {ca: a, certificate: b, key: c, crl: d, server_name: e}}",
         ""},
        {"{transport: tls, host: plc, port: ~, tls: {server_name: \"plc:802\"}}",
         "host.with_port server_name=plc:802"},
        {"{transport: tls, host: plc, port: ~, tls: {root: a}}",
         "key.unlike root=root [ca, certificate, key, crl, server_name]"},
        {"{transport: tcp, host: plc, port: ~, tls: {ca: a}}", "field.needs tls="},
        {"{transport: tcp, host: plc, port: ~, tcp_port: 0}", "field.out_of_range tcp_port=0 [1..65535]"},
        {"{transport: tcp, host: plc, port: ~, tcp_port: 65535}", ""},
        {"{transport: tcp, host: plc}", "?field.without_effect port=/dev/ttyS0"},
        {"{tcp_port: 502}", "?field.without_effect tcp_port=502"},
        {"{framing: tcp}", "field.not_here framing=tcp [rtu, ascii]"},
        {"{transport: tcp, host: plc, port: ~, framing: ascii}", "field.not_here framing=ascii [rtu, tcp]"},
        {"{transport: tls, host: plc, port: ~, framing: rtu}", "field.not_here framing=rtu [tcp]"},
        {"{transport: simulated, framing: tcp}", ""},
        {"{baud: 0}", "field.out_of_range baud=0 [50..10000000]"},
        {"{baud: 230400}", ""},
        {"{baud: fast}", "integer.malformed baud=fast [50..10000000]"},
        {"{parity: mark}", "field.unlike_word parity=mark [none, even, odd]"},
        {"{stop_bits: 3}", "field.out_of_range stop_bits=3 [1..2]"},
        {"{data_bits: 7}", "field.out_of_range data_bits=7 [8]"},
        {"{framing: ascii, data_bits: 7}", ""},
        {"{framing: ascii, data_bits: 8}", ""},
        {"{framing: ascii, data_bits: 6}", "field.out_of_range data_bits=6 [7..8]"},
        {"{rs485: rts}", ""},
        {"{order: fifo}", "field.unlike_word order=fifo [deadline, address]"},
        {"{request_gap: 12}", "duration.no_unit request_gap=12 [0ms..65535ms]"},
        {"{frame_gap: 1.5ms}", ""},
        {"{byte_timeout: 20ms}", ""},
        {"{byte_timeout: 0ms}", "field.out_of_range byte_timeout=0ms [1ms..65535ms]"},
        {"{transport: tcp, host: plc, port: ~, framing: tcp, byte_timeout: 20ms}",
         "?field.without_effect byte_timeout=20ms"},
        {"{devices: ~}", "field.missing devices="},
        {"{devices: []}", "field.empty devices="},
        {"{devices: {a: b}}", "field.not_a_list devices="},
        {"{bauds: 9600}",
         "key.unknown bauds=bauds [name, transport, port, host, tcp_port, tls, framing, baud, parity, "
         "stop_bits, "
         "data_bits, rs485, order, request_gap, frame_gap, byte_timeout, connection, idle_close, "
         "pause_after_connect, connections_per_host, length_tolerance, relay_interval, command_interval, "
         "command_burst, devices]"},
    };
    for (const auto& [keys, expected] : cases) EXPECT_EQ(findings_text({.line = keys}), expected) << keys;
}

TEST(Interpret, UnitZeroOfASerialLineIsABroadcastAndOnlyWritten) {
    struct Broadcast {
        std::string_view line;
        std::string_view device;
        std::string_view variable;
        std::string_view expected;
    };
    constexpr Broadcast kCases[] = {
        {"{}", "{address: 0}", "{read: none, write: 6}", ""},
        {"{}", "{address: 0x0}", "{read: ~, write: 6}", ""},
        {"{}", "{address: 0}", "{read: none, write: 6, verify: true}", "?field.without_effect verify=true"},
        {"{}", "{address: 0, read_modify_write: true}", "{read: none, write: 6}",
         "?field.without_effect read_modify_write=true"},
        {"{}", "{address: 0}", "{read: 3, write: 6}", "field.out_of_range address=0 [1..247]"},
        {"{transport: tcp, host: plc, port: ~, framing: rtu}", "{address: 0}", "{read: none, write: 6}", ""},
        {"{transport: tcp, host: plc, port: ~, framing: rtu}", "{address: 0}", "{read: 3}",
         "field.out_of_range address=0 [1..255]"},
        {"{transport: tcp, host: plc, port: ~, framing: tcp}", "{address: 0}", "{read: 3}", ""},
    };
    for (const auto& c : kCases) {
        const Changes keys{.line = c.line, .device = c.device, .variable = c.variable};
        EXPECT_EQ(findings_text(keys), c.expected) << c.device << c.variable;
        if (!c.expected.starts_with("field")) {
            EXPECT_EQ(interpret(document(keys)).project.lines[0].devices[0].address, kBroadcast);
        }
    }
}

TEST(Interpret, DefaultsOfALineFollowItsTransportAndFraming) {
    const auto line = [](std::string_view keys, std::string_view project = "{}") {
        return interpret(document({.project = project, .line = keys})).project.lines.at(0);
    };
    EXPECT_EQ(line("{framing: ascii}").format.data_bits, 7);
    EXPECT_EQ(line("{framing: ascii, data_bits: 8}").format.data_bits, 8);
    EXPECT_EQ(line("{transport: tcp, host: plc, port: ~}").framing, wire::Framing::tcp);
    EXPECT_EQ(line("{transport: tcp, host: plc, port: ~}").port, "plc");
    EXPECT_EQ(line("{transport: tcp, host: plc, port: ~}").tcp_port, 502);
    EXPECT_EQ(line("{transport: tcp, host: plc, port: ~}").format.baud, 0U);
    EXPECT_EQ(line("{transport: tls, host: plc, port: ~}").tcp_port, 802);
    EXPECT_EQ(line("{transport: tls, host: plc, port: ~}").tls, files_in("certs/", "client"));
    EXPECT_EQ(line("{transport: tls, host: plc, port: ~, tls: {ca: /etc/root.pem, server_name: boiler}}").tls,
              (TlsFiles{"/etc/root.pem", "certs/client.pem", "certs/client.key", "", "boiler"}));
    EXPECT_EQ(line("{transport: simulated}").framing, wire::Framing::rtu);
    EXPECT_EQ(line("{}", "{profile: owen-kc1}").order, PollOrder::address);
    EXPECT_EQ(line("{}", "{profile: owen-kc1}").request_gap, 12ms);
}

TEST(Interpret, Device) {
    const Case cases[] = {
        {"{name: ~}", "field.missing name="},
        {"{name: Kessel mit einem sehr langen Namen}", ""},
        {"{address: ~}", "field.missing address= [1..247]"},
        {"{address: }", "field.empty address= [1..247]"},
        {"{address: 0}", "field.out_of_range address=0 [1..247]"},
        {"{address: 1}", ""},
        {"{address: 247}", ""},
        {"{address: 248}", "?address.reserved address=248 [1..247]"},
        {"{address: 254}", "?address.reserved address=254 [1..247]"},
        {"{address: 255}", "field.out_of_range address=255 [1..247]"},
        {"{address: 010}", "integer.leading_zero address=010 [1..247]"},
        {"{address: 0x10}", ""},
        {"{address: \"16\"}", "field.quoted_number address=16 [1..247]"},
        {"{address: 1.5}", "integer.fraction address=1.5 [1..247]"},
        {"{address: 99999999999999999999}", "field.out_of_range address=99999999999999999999 [1..247]"},
        {"{poll_period: 0}", ""},
        {"{poll_period: 24h}", ""},
        {"{poll_period: 86401s}", "field.out_of_range poll_period=86401s [0ms..24h]"},
        {"{poll_period: 100}", "duration.no_unit poll_period=100 [0ms..24h]"},
        {"{poll_period: 100 milliseconds}", "duration.malformed poll_period=100 milliseconds [0ms..24h]"},
        {"{poll_period: -1s}", "duration.malformed poll_period=-1s [0ms..24h]"},
        {"{response_timeout: 0ms}", "?field.zero_replaced response_timeout=0ms [1ms..65535ms]"},
        {"{response_timeout: 1ms}", ""},
        {"{response_timeout: 65535ms}", ""},
        {"{response_timeout: 65536ms}", "field.out_of_range response_timeout=65536ms [1ms..65535ms]"},
        {"{response_timeout: 500us}", "field.out_of_range response_timeout=500us [1ms..65535ms]"},
        {"{attempts: 0}", "?field.zero_replaced attempts=0 [1..255]"},
        {"{attempts: 255}", ""},
        {"{attempts: 256}", "field.out_of_range attempts=256 [1..255]"},
        {"{attempts: -1}", "field.out_of_range attempts=-1 [1..255]"},
        {"{group_requests: yes}", "boolean.malformed group_requests=yes [true, false]"},
        {"{group_requests: \"true\"}", "boolean.malformed group_requests=true [true, false]"},
        {"{turnaround: 20ms, response_timeout: 20ms}", ""},
        {"{turnaround: learn}", ""},
        {"{turnaround: learn, response_timeout: 20ms}", ""},
        {"{turnaround: lern}", "field.unknown_word turnaround=lern [0ms..65535ms, learn]"},
        {"{turnaround: Learnt}", "field.unknown_word turnaround=Learnt [0ms..65535ms, learn]"},
        {"{turnaround: auto}", "field.unknown_word turnaround=auto [0ms..65535ms, learn]"},
        {"{turnaround: elephant}", "field.unlike_word turnaround=elephant [0ms..65535ms, learn]"},
        {"{turnaround: 20}", "duration.no_unit turnaround=20 [0ms..65535ms, learn]"},
        {"{turnaround: 66s}", "field.out_of_range turnaround=66s [0ms..65535ms, learn]"},
        {"{turnaround: 20ms, response_timeout: 19ms}", "?device.timeout_short response_timeout=19ms"},
        {"{registers_per_request: 20}", ""},
        {"{group_requests: false, registers_per_request: 20}", ""},
        {"{strategy: single, registers_per_request: 20}", "?field.without_effect registers_per_request=20"},
        {"{group_requests: true, registers_per_request: 2}", ""},
        {"{group_requests: true, registers_per_request: 125}", ""},
        {"{group_requests: true, registers_per_request: 0}",
         "field.out_of_range registers_per_request=0 [2..125]"},
        {"{group_requests: true, registers_per_request: 1}",
         "field.out_of_range registers_per_request=1 [2..125]"},
        {"{group_requests: true, registers_per_request: 126}",
         "field.out_of_range registers_per_request=126 [2..125]"},
        {"{group_requests: true, registers_per_request: 16.5}",
         "integer.fraction registers_per_request=16.5 [2..125]"},
        {"{group_requests: true, registers_per_request: many}",
         "integer.malformed registers_per_request=many [2..125]"},
        {"{strategy: classic}", ""},
        {"{strategy: clasic}", "field.unknown_word strategy=clasic [single, classic, optimal]"},
        {"{strategy: optimal}", ""},
        {"{group_requests: false, strategy: classic}", "?strategy.grouping_off strategy=classic"},
        {"{group_requests: true, strategy: single}", ""},
        {"{gaps: learn}", ""},
        {"{group_requests: false, gaps: learn}", "?field.without_effect gaps=learn"},
        {"{poll_enable: go}", ""},
        {"{poll_enable: stop}", "local.unknown poll_enable=stop"},
        {"{poll_enable: state}", "local.type poll_enable=state [bool]"},
        {"{status: state}", ""},
        {"{status: go}", "local.type status=go [int16, uint16, int32, uint32, int64, uint64]"},
        {"{round_trip: 5ms}", "?field.without_effect round_trip=5ms"},
        {"{variables: ~}", ""},
        {"{variables: 7}", "field.not_a_list variables=7"},
        {"{notation: zero_based}", "?field.without_effect notation=zero_based"},
        {"{notation: modicon}", "field.unlike_word notation=modicon [standard, coils_at_20001, zero_based]"},
        {"{variables: [7]}", "field.not_a_mapping variables[0]=7"},
        {"{comment: \"two\nlines\"}", "field.control_character comment=two\nlines"},
    };
    for (const auto& [keys, expected] : cases) EXPECT_EQ(findings_text({.device = keys}), expected) << keys;
}

TEST(Interpret, UnitsOverTcpGoFrom0To255) {
    constexpr std::string_view kTcp = "{transport: tcp, host: plc, port: ~}";
    for (const auto* address : {"0", "1", "248", "255"}) {
        const auto device = std::string("{address: ") + address + "}";
        EXPECT_EQ(findings_text({.line = kTcp, .device = device}), "") << address;
    }
    EXPECT_EQ(findings_text({.line = kTcp, .device = "{address: 256}"}),
              "field.out_of_range address=256 [0..255]");
}

TEST(Interpret, ALearntTurnaround) {
    const auto device = [](const Document& document) {
        return interpret(document).project.lines[0].devices[0];
    };
    constexpr std::string_view kLearn = "{turnaround: learn}";
    const auto serial = device(document({.device = kLearn}));
    EXPECT_TRUE(serial.learn_turnaround);
    EXPECT_FALSE(serial.turnaround);
    EXPECT_FALSE(device(document({.device = "{turnaround: 5ms}"})).learn_turnaround);

    constexpr std::string_view kTcp = "{transport: tcp, host: plc, port: ~}";
    EXPECT_EQ(findings_text({.line = kTcp, .device = kLearn}), "");
    EXPECT_TRUE(device(document({.line = kTcp, .device = kLearn})).learn_turnaround);
    constexpr std::string_view kAhead = "{turnaround: learn, in_flight: 4}";
    EXPECT_EQ(findings_text({.line = kTcp, .device = kAhead}), "?field.without_effect turnaround=learn");
    EXPECT_FALSE(device(document({.line = kTcp, .device = kAhead})).learn_turnaround);

    constexpr std::string_view kOwen = "{profile: owen-kc1}";
    EXPECT_EQ(findings_text({.project = kOwen, .device = kLearn}), "?field.without_effect turnaround=learn");
    EXPECT_FALSE(device(document({.project = kOwen, .device = kLearn})).learn_turnaround);
}

TEST(Interpret, AMeasuredTurnaroundCountsWhereNoneIsWrittenAndEnoughWasMeasured) {
    Device device;
    device.response_timeout = 500ms;
    device.times.measured = {.exchanges = 99, .longest = 8ms, .p999 = 7ms};
    device.learn_turnaround = true;
    EXPECT_FALSE(device.measured_turnaround());
    EXPECT_EQ(device.wait(true), 500ms);
    device.times.measured.exchanges = 100;
    EXPECT_EQ(device.measured_turnaround(), 8ms);
    EXPECT_EQ(device.wait(true), 20ms) << "not less";
    EXPECT_EQ(device.wait(false), 500ms);
    device.times.measured.lateness = 412ms;
    EXPECT_EQ(device.measured_turnaround(), 412ms);
    EXPECT_EQ(device.wait(true), 824ms);
    device.response_timeout_set = true;
    EXPECT_EQ(device.wait(true), 500ms) << "a written value always counts";
    device.response_timeout_set = false;
    device.learn_turnaround = false;
    EXPECT_EQ(device.wait(true), 500ms);
    device.turnaround = 30ms;
    EXPECT_EQ(device.expected_turnaround(), 30ms);
    EXPECT_EQ(device.wait(true), 30ms);
}

TEST(Interpret, ProfileOfTheController) {
    constexpr std::string_view kOwen = "{profile: owen-kc1}";
    const Case lines[] = {
        {"{transport: tcp, host: plc, port: ~}", "field.not_here transport=tcp [serial, simulated]"},
        {"{transport: simulated, framing: tcp}", "field.not_here framing=tcp [rtu, ascii]"},
        {"{framing: tcp}", "field.not_here framing=tcp [rtu, ascii]"},
        {"{baud: 115200}", ""},
        {"{baud: 230400}", "field.out_of_range baud=230400 [50..115200]"},
        {"{request_gap: 11ms}", "field.out_of_range request_gap=11ms [12ms..65535ms]"},
        {"{request_gap: 20ms}", ""},
        {"{order: deadline}", ""},
    };
    for (const auto& [keys, expected] : lines)
        EXPECT_EQ(findings_text({.project = kOwen, .line = keys}), expected) << keys;
    const Case devices[] = {
        {"{name: Четырнадцать14}", ""},
        {"{name: Пятнадцать 1234}", "field.length name=Пятнадцать 1234 [1..14]"},
        {"{poll_period: 65535ms}", ""},
        {"{poll_period: 65536ms}", "field.out_of_range poll_period=65536ms [0ms..65535ms]"},
        {"{group_requests: true, registers_per_request: 125}", ""},
    };
    for (const auto& [keys, expected] : devices)
        EXPECT_EQ(findings_text({.project = kOwen, .device = keys}), expected) << keys;
    EXPECT_EQ(findings_text({.project = kOwen,
                             .line = "{framing: ascii}",
                             .device = "{group_requests: true, registers_per_request: 62}"}),
              "?device.registers_cut registers_per_request=62 [2..125]");
    EXPECT_EQ(findings_text({.project = kOwen,
                             .line = "{framing: ascii}",
                             .device = "{group_requests: true, registers_per_request: 125}"}),
              "?device.registers_cut registers_per_request=125 [2..125]");
    EXPECT_EQ(findings_text({.project = kOwen,
                             .line = "{framing: ascii}",
                             .device = "{group_requests: true, registers_per_request: 126}"}),
              "field.out_of_range registers_per_request=126 [2..125]");
    EXPECT_EQ(findings_text({.project = kOwen,
                             .line = "{framing: ascii}",
                             .device = "{group_requests: true, registers_per_request: 61}"}),
              "");
}

TEST(Interpret, RequestsThatOnlyWriteAreCutSooner) {
    const auto findings = [](const std::string& keys, const std::string& variables) {
        const std::string first =
            "{takt: 1, profile: owen-kc1, lines: [{name: L, port: p, framing: ascii, devices: "
            "[{name: D, address: 1, group_requests: true, " +
            keys + ", variables: [";
        std::string all;
        for (const auto& finding : interpret({{"x"}, flow(first + variables + "]}]}]}")}).findings)
            all += finding.code + " " + finding.value + " [" + finding.allowed + "]";
        return all;
    };
    std::string written;
    std::string both;
    for (int i = 0; i < 30; ++i) {
        const auto n = std::to_string(i);
        const auto variable = "{name: V" + n + ", type: int32, register: " + std::to_string(2 * i) +
                              ", write: 0x10, write_on_change: true";
        written += variable + "}, ";
        both += variable + ", read: 0x03}, ";
    }
    const std::string cut = "device.registers_cut 60 [2..125]";
    EXPECT_EQ(findings("registers_per_request: 60", written), cut);
    EXPECT_EQ(findings("registers_per_request: 59", written), "");
    EXPECT_EQ(findings("registers_per_request: 60", both), "");
    EXPECT_EQ(findings("registers_per_request: 60",
                       "{name: V, type: int, register: 0, read: none, write: 0x10, "
                       "write_on_change: true}"),
              "");
    EXPECT_EQ(findings("registers_per_request: 62", written), "device.registers_cut 62 [2..125]");
}

std::string firmware_findings(const Node& root) {
    return findings_text({.findings = interpret_firmware({{"board.yaml"}, root}).findings});
}

TEST(Interpret, Firmware) {
    const Node base = flow(
        "{core_clock: 14000000, wakeup_time: 2us, uart_clock_ppm: 100, request_period: 1s,"
        " active_ua_per_mhz: 114, sleep_na: 900}");
    const auto checked = interpret_firmware({{"board.yaml"}, base});
    EXPECT_EQ(firmware_findings(base), "");
    EXPECT_EQ(checked.firmware.uart_clock, 14'000'000U) << "that of the core";
    EXPECT_EQ(checked.firmware.timer_clock_ppm, 100U) << "that of the UART";
    EXPECT_EQ(checked.firmware.format, (wire::CharacterFormat{19200, 8, wire::Parity::even, 1}));
    EXPECT_EQ(checked.firmware.wakeup_time, 2us);
    EXPECT_FALSE(checked.firmware.battery_mah);
    EXPECT_EQ(checked.firmware.timer_clock, 1'000'000U);
    const auto slow = interpret_firmware({{"board.yaml"}, changed(base, flow("{core_clock: 500000}"))});
    EXPECT_EQ(slow.firmware.timer_clock, 500'000U) << "no timer is faster than the core";
    const auto unitless = [&](const std::string& number) {
        const auto root = changed(base, flow("{wakeup_time: " + number + "}"));
        return interpret_firmware({{"board.yaml"}, root}).findings.at(0).arguments.at(0).second;
    };
    EXPECT_EQ(unitless("4"), "4ms, 4us") << "4s is out of range";
    EXPECT_EQ(unitless("40"), "40us");
    EXPECT_EQ(unitless("4000000"), "4000000ms");
    const Case cases[] = {
        {"{sleep_na: ~}", "field.missing sleep_na= [0..100000000]"},
        {"{core_clock: 999}", "field.out_of_range core_clock=999 [1000..1000000000]"},
        {"{core_clock: 14MHz}", "integer.malformed core_clock=14MHz [1000..1000000000]"},
        {"{wakeup_time: 2}", "duration.no_unit wakeup_time=2 [0ms..10ms]"},
        {"{parity: maybe}", "field.unlike_word parity=maybe [none, even, odd]"},
        {"{registers: 126}", "field.out_of_range registers=126 [1..125]"},
        {"{stop_bits: 2, parity: none, battery_mah: 1}", ""},
    };
    for (const auto& [keys, expected] : cases)
        EXPECT_EQ(firmware_findings(changed(base, flow(keys))), expected) << keys;
    EXPECT_EQ(firmware_findings(changed(base, flow("{timer_bit: 24}"))).substr(0, 20),
              "key.unknown timer_bi");
    EXPECT_EQ(firmware_findings(changed(base, flow("{framing: rtu}"))).substr(0, 10), "key.unlike")
        << "a key of projects does not belong elsewhere in the file";
    EXPECT_EQ(firmware_findings(flow("[1]")), "field.not_a_mapping =");
}

}  // namespace interpret_test
}  // namespace takt::model::test
