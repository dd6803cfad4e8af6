// Every rule of a project has a file that breaks it, and its finding is complete in each language.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "takt/file/load.hpp"
#include "takt/model/findings.hpp"
#include "takt/text/catalogue.hpp"

namespace takt {
namespace finding_texts_test {

std::string repeated(int times, const std::string& text) {
    std::string all;
    while (times-- > 0) all += text;
    return all;
}

std::string numbered(int times, const std::string& before, const std::string& after) {
    std::string all;
    for (int i = 1; i <= times; ++i) all += before + std::to_string(i) + after;
    return all;
}

std::vector<std::string> bad_projects() {
    const std::string line =
        "lines:\n- {name: N, port: /dev/ttyS0, devices: [{name: D, address: 1, variables: [\n";
    return {
        "- 1\n",
        "takt: 1\nlines: []\n",
        "takt: 1\nlines:\n- {name:N, transport: tcp, host: 127.0.0.1:502, qqqqqqqqqqqq: 1, baudrate: 1, "
        "baud: 9600, devices: []}\n"
        "- {name: M, transport: tcp, host: 10.0.0.300, frame_gap: \"0,1\", devices: [{name: D, address: 1, "
        "turnaround: 20ms, response_timeout: 10ms, "
        "variables: [{name: V, type: int, register: 0, scale: \"0,1\"}, {name: W, type: int, read: 3, "
        "register: \"1,000\"}]}]}\n",
        "takt: 1\nlines:\n- {name: N, host: 10.0.0.5/24, port: 502, parity: E, devices: []}\n"
        "- {name: O, port: \"/dev/ttyS0,9600\", devices: [{name: D, address: 1, fc16: true, poll_period: "
        "\"1,000ms\", variables: [{name: V, type: int, register: 0, write: 0x16}]}]}\n",
        "takt: 1\nlines:\n- {name: N, port: /dev/ttyS0, devices: [{name: D, address: 1, offers: [5..9], "
        "variables: [{name: A, type: float, register: 9, read: 3}]}]}\n",
        "takt: 1\nlines:\n- {name: N, port: /dev/ttyS0, devices: [{name: D, address: 1, offers: {coil: [5]}, "
        "variables: [{name: A, type: float, register: 9, read: 3}]}]}\n",
        "takt: 1\n" + line +
            "{name: A, type: bool, register: 17, read: 1}, {name: B, type: float, register: 1, read: 3},\n"
            "{name: D, type: bool, register: 5, read: 2},\n"
            "{name: C, type: int, register: 2, read: 3}]}]}\n",
        "takt: 1\n" + line + "{name: A, type: int, register: 1, read: 3}]}], idle_close: 1s}\n" +
            "- {name: O, host: h, devices: [{name: E, address: 1, variables: [{name: B, type: int, register: "
            "1, "
            "read: 3}]}]}\n"
            "- {name: P, host: h, devices: [{name: F, address: 1, variables: [{name: C, type: int, register: "
            "1, "
            "read: 3}]}]}\n",
        "takt: 2\nprofil: x\nbaud: 9600\nlines:\n- 5\nlocals:\n- {name: a, type: real}\n",
        "takt: \"1\"\nprofile: [x]\nlines: {}\nderive_timeouts: yes\ntimeout_margin: 5\nlocals:\n",
        "profile: x\nlines:\n",
        "takt: 1\n" + line +
            "{name: system.time, type: int, register: 0, read_trigger: system.uptime},\n"
            "{name: A, type: int, register: 1, read_trigger: system.nothing, status: system.uptime}]}]}\n"
            "- {name: O, port: /dev/ttyS1, devices: [{name: E, address: 1, poll_enable: "
            "system.device.E.answering, variables: []}]}\n"
            "servers: [{name: S, listen: x, units: [{address: 1, banks: [{area: holding_register, items: "
            "[0]}], "
            "variables: [{name: B, area: holding_register, register: 0, type: int, source: {variable: "
            "system.uptime}}]}]}]\n",
        "takt: 1\nservers: [{name: S, listen: '*', units: [{address: 1, banks: [{area: holding_register, "
        "items: "
        "[0..1]}], variables: [{name: A, type: int, area: holding_register, register: 0}, {name: B, type: "
        "int, "
        "area: holding_register, register: 0}]}]}]\n",
        "takt: 1\n" + line +
            "{name: A, type: int, register: 1, read: 3}]}]}\nservers:\n- {name: S, listen: x, units: [\n"
            "  {address: 1, mirror: [{area: coil}, {first: 3}, {first: 3}]},\n"
            "  {address: 2, mirror: {first: 65536}}, {address: 3, mirror: {first: 65535, devices: [D]}}]}\n",
        "takt: 1\n" + line +
            "{name: A, type: float, register: 1, read: 3}]}]}\nservers:\n- {name: S, listen: x, units: "
            "[{address: 1, mirror: {first: 65535}}]}\n",
        // lines and devices
        "takt: 1\nlines:\n- {name: A, framing: tcp, baud: 07, stop_bits: 1.5, data_bits: x, tcp_port: 502,\n"
        "   devices: [{name: \"\", address: 248, attempts: 0, poll_period: 1w, registers_per_request: 999,\n"
        "              status: none_such, strategy: optimal, backoff: {first: 2s, limit: 1s}, "
        "round_trip: {longest: 1ms, usual: 2ms, exchanges: 100}, comment: "
        "\"a\\tb\"},\n"
        "             {name: D, address: 248, group_requests: false, strategy: classic}]}\n"
        "- {name: B, port: /dev/ttyS0, devices: [{name: D, address: 1, status: b}]}\n"
        "- {name: B, port: /dev/ttyS0, devices: [{name: D, address: 2, poll_enable: c}]}\n"
        "host: 1ms\n"
        "locals: [{name: b, type: float, min_interval: 1s, default: x}, {name: b, type: string, default: " +
            repeated(251, "x") + "}]\n",
        "takt: 1\n" + line + numbered(33, "]},{name: D, address: ", ", variables: [") + "]}]}\n",
        "takt: 1\nprofile: owen-kc1\n" + line +
            numbered(1100, "{name: V", ", type: int, register: 0, read: 3},\n") + "]},{name: E, address: 2" +
            numbered(32, "},{name: F, address: ", "") + "}]}\n",
        // variables
        "takt: 1\n" + line +
            "{name: W0, type: int, register: 1, read: 3, enumeration: {a: b, 1: c, 0x1: d}}, {name: W1, "
            "type: "
            "float, register: 1, read: 3, bits: {0: a}},\n"
            "{name: A0, type: int, register: 40001, read: 3}, {name: A1, type: int, register: 400001, read: "
            "3},\n"
            "{name: A, type: int},\n"
            "{name: B, type: int, register: 1, coil: 1, read: 3},\n"
            "{name: C, type: int, register: 1},\n"
            "{name: D, type: int, register: 1, area: coil, read: none, verify: true},\n"
            "{name: E, type: int, register: 1, area: coil, read: 3},\n"
            "{name: F, type: int, register: 1, read: 4, write: 0x10, bit: 1, length: 1},\n"
            "{name: F2, type: int, register: 1, area: input_register, read: 4, write: 0x10},\n"
            "{name: G, type: float, register: 65535, read: 3, write: 6, default: 1e99},\n"
            "{name: H, type: bool, register: 1, read: 3, scale: 2},\n"
            "{name: I, type: bool, coil: 1, read: 3},\n"
            "{name: J, type: int, register: 1, write: 6, read_trigger: x, read: none, scale: 0, offset: x},\n"
            "{name: K, type: int, register: 1, read: 5, write_on_change: true, period: 0, deadline: 1s},\n"
            "{name: L, type: string, register: 1, read: 3, default: abc},\n"
            "{name: M, type: int, reference: 40001},\n"
            "{name: N, type: int, register: 1, write: 6, write_range: 5},\n"
            "{name: O, type: int, reference: \"400001\", area: coil},\n"
            "{name: P, type: int, reference: \"4\"}]}]}\n",
        "takt: 1\n" + line +
            "]},{name: E, address: 2, strategy: classic, registers_per_request: 2, variables: [\n"
            "{name: A, type: double, register: 0, read: 3},\n"
            "{name: B, type: bool, register: 1, bit: 2, read: 3, write: 6}]},\n"
            "{name: F, address: 3, registers_per_request: 2, readable: [9..5, x], write_single: only,\n"
            " strategy: optimal, variables: [\n"
            "{name: C, type: double, register: 0, read: 3, write: 0x10, burst: 2}]}]}\n",
        "takt: 1\nservers:\n- {name: S, listen: x, access: [{rule: deny, peers: [1.2.3]}], units: [{address: "
        "1, banks: [{area: coil, items: [0], "
        "retain: [1]},\n"
        "{area: coil, items: [1]}, {area: input_register, items: [0], overlay: holding_register}],\n"
        "limits: [{registers: [0], least: 2, greatest: 1}], files: [{number: 1, records: 1}, {number: 1, "
        "records: 1}],\n"
        "fifos: [{register: 0, values: [" +
            repeated(32, "1,") +
            "]}], variables: [{name: V, type: int, register: 5, area: holding_register}]}],\n"
            "  relay: [{line: none_such}]}\n",
        "takt: 1\n" + line +
            "{name: P, type: int, register: 0, read: 3}]}]}\nservers:\n"
            "- {name: S, listen: x, relay: [{line: none_such}]}\n"
            "- {name: T, listen: '*', units: [{address: 1, banks: [{area: coil, items: [0..99], overlay: "
            "holding_register},\n{area: holding_register, items: [0..5], read_only: [6]}], limits: "
            "[{registers: [6], least: 0, greatest: 1}, {registers: [6], least: 2, greatest: 3}, {registers: "
            "[0], "
            "least: 2, greatest: 3}],\nvariables: [{name: A, type: int, register: 0, area: holding_register, "
            "default: 9, source: {constant: 1}},\n{name: B, type: int, register: 0, area: holding_register, "
            "source: {constant: 2}}, {name: C, type: int, register: 9, area: holding_register}]}]}\n"
            "- {name: U, listen: '*', units: [{address: 1, banks: []}]}\n",
        // sources and instruments
        "takt: 1\n" + line +
            "{name: P, type: int, register: 0, read: 3}]}]}\n"
            "instruments:\n- {name: I, port: /dev/ttyS1, exchanges: [{request: '\\q', answer: {until: x, "
            "pattern: y,"
            " length: 1}},\n  {answer: {length: 1, checksum: crc16, fields: [{name: a, offset: 1, type: "
            "int16}]}}]}\n"
            "- {name: J, port: /dev/ttyS2, exchanges: [{request: a, answer: {until: b, pattern: '{v}'}}],\n"
            "  reset: {until: b, pattern: '{*}'}, commands: [{name: c, request: 'T', least: 2, greatest: "
            "1},\n"
            "  {name: d, request: 'T{value}', expires: 1ms, answer: {until: b, pattern: '{value:text}'}}]}\n"
            "servers:\n- {name: S, listen: x, units: [{address: 1, banks: [{area: holding_register, items: "
            "[0..99]}], variables: [\n"
            "{name: A, type: int, register: 0, area: holding_register, source: {}, writes_to: {variable: "
            "P}},\n"
            "{name: B, type: string, length: 2, register: 4, area: holding_register, source: {variable: "
            "P}},\n"
            "{name: C, type: int, register: 6, area: holding_register, source: {variable: Q}},\n"
            "{name: F, type: int, register: 8, area: holding_register, writes_to: {instrument: J.x}},\n"
            "{name: E, type: int, register: 7, area: holding_register, source: {command: {run: [], pattern: "
            "x}}}]}]}\n",
        // transports, byte orders, registers of a request
        "takt: 1\ninstruments: [{name: K, transport: tls, host: h}]\nlines:\n- {name: T, transport: tcp, "
        "host: h, devices: [{name: D, address: 1, variables: [\n"
        "{name: A, type: int, register: 0, read: 3, byte_order: 2413},\n"
        "{name: B, type: float, register: 2, read: 3, byte_order: 12},\n"
        "{name: C, type: float, register: 4, read: 3, byte_order: 2143, high_byte_first: false}]}]}\n",
        "takt: 1\nprofile: owen-kc1\nlines:\n- {name: A, port: /dev/ttyS0, framing: ascii, devices: [{name: "
        "D,\n"
        "address: 1, group_requests: true, registers_per_request: 100, variables: []}]}\n",
        "takt: 1\n" + line +
            "{name: A, type: int, register: 1, read: 3, tags: [a b]}, {name: B, type: int, register: 2, "
            "used: "
            "false}]}]}\noutputs:\n"
            "- {name: Cloud 1, transport: mqtt, brokers: [b:1883, mqtt://, mqtt://u:p@b, mqtt://b, "
            "mqtt://b], "
            "password: x, user: u, password_file: f, password_env: F, client_id: c, on_change: false, "
            "topic: 'a/{tag}', variables: [B, C, D*], commands: [A, A*]}\n"
            "- {name: o2, transport: mqtt, client_id: c, brokers: [mqtt://1, mqtt://2, mqtt://3, mqtt://4, "
            "mqtt://5, mqtt://6, mqtt://7, mqtt://8, mqtt://9], topic: 'a{', devices: [X*]}\n"
            "- {name: o3, transport: mqtt, client_id: c, brokers: [mqtt://b], topic: a/+, select: "
            "[{variables: "
            "['*']}, {variables: [A]}]}\n"
            "- {name: o4, transport: mqtt, brokers: [mqtt://b], topic: 'a//b'}\n"
            "- {name: o5, transport: mqtt, brokers: [mqtt://b], topic: 'a/{variable}', message: device, "
            "retain: true}\n"
            "- {name: o6, transport: mqtt, brokers: [mqtt://b], control_topic: c, topic: c/set}\n"
            "- {name: h1, transport: history, variables: [A, A]}\n- {name: h2, transport: history}\n"
            "- {name: o7, transport: mqtt, brokers: [mqtt://b], control_topic: c, quota_mb: 32, round_trip: "
            "1s, period: 1ms, backlog: array}\n",
        "takt: 1\n" + line +
            "{name: A, type: int, register: 1, read: 3}, {name: B, type: int, register: 2, read: 3}]}]}\n"
            "outputs:\n- {name: o, transport: mqtt, brokers: [mqtt://b], topic: a}\n",
        "takt: 1\n" + line + repeated(1002, "{name: x, type: int, register: 0, read: 3},\n") + "]}]}\n",
    };
}

std::string all_texts(text::Language language, const std::string& code, const model::Finding& finding) {
    // A brace of a value, as in a topic, is no placeholder of the text.
    auto masked = finding;
    std::ranges::replace(masked.value, '{', '<');
    std::ranges::replace(masked.allowed, '{', '<');
    for (auto& [name, text] : masked.arguments) std::ranges::replace(text, '{', '<');
    std::vector<text::Argument> arguments{
        {"value", masked.value}, {"allowed", masked.allowed}, {"path", masked.path}};
    for (const auto& [name, text] : masked.arguments) arguments.push_back({name, text});
    return text::message(language, code, arguments);
}

/// The codes of what is found in a document, each of which must have its texts.
void judge(const model::Document& document, std::set<std::string>& broken) {
    for (const auto& finding : model::interpret(document).findings) {
        if (!broken.insert(finding.code).second) continue;
        for (const auto language : text::kLanguages)
            for (const auto& code : {finding.code, finding.code + ".advice"}) {
                EXPECT_TRUE(text::has(language, code)) << code;
                EXPECT_EQ(all_texts(language, code, finding).find('{'), std::string::npos)
                    << all_texts(language, code, finding);
            }
    }
}

TEST(FindingTexts, EveryRuleIsBrokenAndSpokenOf) {
    std::set<std::string> broken;
    judge({}, broken);
    for (const auto& project : bad_projects()) {
        const auto loaded = file::load_text("bad.yaml", project);
        ASSERT_TRUE(loaded.findings.empty()) << loaded.findings.front().code << "\n" << project;
        judge(loaded.document, broken);
    }
    for (const auto code : model::finding_codes()) EXPECT_TRUE(broken.contains(std::string(code))) << code;
}

}  // namespace finding_texts_test
}  // namespace takt
