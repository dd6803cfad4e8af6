// Each advice of a rule, followed literally, removes its finding, and the project is then accepted.
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "takt/file/load.hpp"
#include "takt/model/findings.hpp"

namespace takt {
namespace advice_test {

/// The part of a project that has the text of a case.
enum class At { project, line, device, variable, local, server, unit, served, instrument, output };

struct Case {
    const char* code;
    At at;
    const char* broken;
    std::vector<const char*> fixed;  ///< what the advice names; each alone is enough
};

/// A project that is accepted.
constexpr const char* kLine =
    "takt: 1\nlines:\n- {name: L, port: /dev/ttyS0, devices: [{name: D, address: 1}]}\n";

std::string project_of(At at, const std::string& text) {
    const std::string variable = "{name: V, type: int, register: 0, read: 0x03}";
    const std::string two = variable + ", {name: W, type: float, register: 2, read: 3, write: 16}";
    const auto device = [](const std::string& settings, const std::string& variables) {
        return "{name: D, address: 1, " + settings + "variables: [" + variables + "]}";
    };
    const auto line = [](const std::string& settings, const std::string& devices) {
        return "lines:\n- {name: L, " + settings + "devices: [" + devices + "]}\n";
    };
    const std::string serial = "port: /dev/ttyS0, ";
    const std::string usual = line(serial, device("", variable));
    const auto unit = [](const std::string& settings) {
        return "servers:\n- {name: S, listen: '*', units: [{address: 1, " + settings + "}]}\n";
    };
    switch (at) {
        case At::project: return text;
        case At::line: return "takt: 1\n" + line(text + ", ", device("", variable));
        case At::device: return "takt: 1\n" + line(serial, device(text + ", ", variable));
        case At::variable:
            return "takt: 1\nlocals: [{name: go, type: bool}]\n" + line(serial, device("", text));
        case At::local: return "takt: 1\n" + usual + "locals: [" + text + "]\n";
        case At::server: return "takt: 1\n" + usual + "servers:\n" + text + "\n";
        case At::unit: return "takt: 1\n" + usual + unit(text);
        case At::served:
            return "takt: 1\n" + usual +
                   unit("banks: [{area: holding_register, items: [0..9]}], variables: [" + text + "]");
        case At::output:
            return "takt: 1\n" + line(serial, device("", two)) + "outputs:\n- {name: o, transport: mqtt, " +
                   text + "}\n";
        case At::instrument: break;
    }
    const std::string asks = "exchanges: [{answer: {until: x, pattern: '{v}'}}]";
    return "takt: 1\nlines: []\ninstruments: [{name: I, port: p, " + asks + ", " + text + "}]\n";
}

const std::vector<Case>& cases() {
    static const std::vector<Case> kCases{
        // documents and keys
        {"document.empty", At::project, "# nothing\n", {kLine}},
        {"document.not_a_project", At::project, "- 1\n", {kLine}},
        {"project.version",
         At::project,
         "takt: 2\nlines:\n- {name: L, port: /dev/ttyS0, devices: [{name: D, address: 1}]}\n",
         {kLine}},
        {"key.unknown", At::device, "addres: 2", {"comment: removed"}},
        {"key.unknown", At::device, "atempts: 2", {"attempts: 2", "comment: removed"}},
        {"key.unlike", At::device, "qqqqqqqqqqqq: 1", {"comment: removed"}},
        {"key.elsewhere", At::device, "baud: 9600", {"comment: moved"}},
        {"key.no_space",
         At::variable,
         "{name:V, type: int, register: 0, read: 3}",
         {"{name: V, type: int, register: 0, read: 3}"}},
        {"field.missing",
         At::variable,
         "{type: int, register: 0, read: 3}",
         {"{name: V, type: int, register: 0, read: 3}"}},
        {"field.empty", At::device, "poll_period: ", {"poll_period: 1s", "comment: removed"}},
        {"field.not_a_value", At::device, "attempts: [3]", {"attempts: 3"}},
        {"field.not_a_list", At::project, "takt: 1\nlines: {}\n", {kLine}},
        {"lines.none", At::project, "takt: 1\nlines: []\n", {kLine}},
        {"field.not_a_mapping", At::variable, "5", {"{name: V, type: int, register: 0, read: 3}"}},
        {"field.not_a_group",
         At::project,
         "takt: 1\nhost: 1ms\nlines:\n- {name: L, port: /dev/ttyS0, devices: [{name: D, address: 1}]}\n",
         {"takt: 1\nhost: {jitter: 1ms}\nlines:\n- {name: L, port: /dev/ttyS0, devices: [{name: D, address: "
          "1}]}\n"}},
        {"field.out_of_range", At::device, "attempts: 999", {"attempts: 255"}},
        {"field.unknown_word", At::device, "strategy: optimum", {"strategy: optimal"}},
        {"field.unknown_word", At::line, "port: /dev/ttyS0, parity: E", {"port: /dev/ttyS0, parity: even"}},
        {"field.unlike_word", At::line, "port: /dev/ttyS0, parity: mark", {"port: /dev/ttyS0, parity: odd"}},
        {"field.quoted_number", At::device, "attempts: \"3\"", {"attempts: 3"}},
        {"field.length", At::local, "{name: \"\", type: bool}", {"{name: go, type: bool}"}},
        {"field.control_character", At::device, "comment: \"a\\tb\"", {"comment: a b"}},
        {"field.zero_replaced", At::device, "attempts: 0", {"attempts: 1"}},
        // values
        {"integer.malformed", At::device, "attempts: x", {"attempts: 16", "attempts: 0x10"}},
        {"integer.fraction", At::device, "attempts: 1.5", {"attempts: 2"}},
        {"integer.leading_zero", At::device, "attempts: 07", {"attempts: 7"}},
        {"number.malformed",
         At::variable,
         "{name: V, type: int, register: 0, read: 3, scale: x}",
         {"{name: V, type: int, register: 0, read: 3, scale: 0.1}",
          "{name: V, type: int, register: 0, read: 3, scale: -1.5e3}"}},
        {"number.comma",
         At::variable,
         "{name: V, type: int, register: 0, read: 3, scale: \"0,1\"}",
         {"{name: V, type: int, register: 0, read: 3, scale: 0.1}"}},
        {"number.comma", At::device, "deadline: \"1,000s\"", {"deadline: 1000s", "deadline: 1.000s"}},
        {"number.thousands", At::line, "host: h, tcp_port: \"1,502\"", {"host: h, tcp_port: 1502"}},
        {"boolean.malformed",
         At::device,
         "group_requests: yes",
         {"group_requests: true", "group_requests: false"}},
        {"duration.malformed", At::device, "poll_period: soon", {"poll_period: 100ms", "poll_period: 1.5s"}},
        {"duration.no_unit", At::device, "poll_period: 100", {"poll_period: 100ms", "poll_period: 100s"}},
        {"range.malformed", At::device, "no_read: [x]", {"no_read: [5]", "no_read: [5..9]"}},
        {"range.reversed", At::device, "no_read: [9..5]", {"no_read: [5..9]"}},
        {"function.not_allowed",
         At::variable,
         "{name: V, type: int, register: 0, read: 5}",
         {"{name: V, type: int, register: 0, read: 3}", "{name: V, type: int, register: 0, read: 4}"}},
        // names
        {"name.duplicate",
         At::variable,
         "{name: V, type: int, register: 0, read: 3}, {name: V, type: int, register: 1, read: 3}",
         {"{name: V, type: int, register: 0, read: 3}, {name: W, type: int, register: 1, read: 3}"}},
        {"name.reserved",
         At::variable,
         "{name: system.time, type: int, register: 0, read: 3}",
         {"{name: time, type: int, register: 0, read: 3}"}},
        {"service.unknown",
         At::variable,
         "{name: V, type: int, register: 0, read: 3, read_trigger: system.pulse}",
         {"{name: V, type: int, register: 0, read: 3, read_trigger: system.pulse_1s}"}},
        {"service.type",
         At::variable,
         "{name: V, type: int, register: 0, read: 3, read_trigger: system.uptime}",
         {"{name: V, type: int, register: 0, read: 3, read_trigger: system.pulse_1min}"}},
        {"service.circular", At::device, "poll_enable: system.device.D.answering", {"comment: removed"}},
        {"local.unknown",
         At::variable,
         "{name: V, type: int, register: 0, read: 3, read_trigger: goo}",
         {"{name: V, type: int, register: 0, read: 3, read_trigger: go}"}},
        {"local.undeclared", At::device, "status: none_such", {"comment: removed"}},
        {"local.type",
         At::variable,
         "{name: V, type: int, register: 0, read: 3, status: go}",
         {"{name: V, type: int, register: 0, read: 3, read_trigger: go}"}},
        {"local.not_a_trigger",
         At::local,
         "{name: n, type: float, min_interval: 1s}",
         {"{name: n, type: float}", "{name: n, type: bool, min_interval: 1s}"}},
        {"burst.alone",
         At::local,
         "{name: n, type: bool, burst: 2}",
         {"{name: n, type: bool, burst: 2, min_interval: 1s}", "{name: n, type: bool}"}},
        // lines and devices
        {"host.with_port",
         At::line,
         "transport: tcp, host: 127.0.0.1:502",
         {"transport: tcp, host: 127.0.0.1, tcp_port: 502"}},
        {"host.no_address",
         At::line,
         "transport: tcp, host: 10.0.0.300",
         {"transport: tcp, host: 192.168.1.10"}},
        {"host.malformed",
         At::line,
         "transport: tcp, host: 10.0.0.5/24",
         {"transport: tcp, host: 192.168.1.10", "transport: tcp, host: plc-1"}},
        {"line.port_number", At::line, "host: plc, port: 502", {"host: plc, tcp_port: 502"}},
        {"line.port_settings", At::line, "port: \"/dev/tty0,9600\"", {"port: /dev/tty0, baud: 9600"}},
        {"line.port_number", At::line, "port: 502", {"port: /dev/ttyUSB0"}},
        {"field.needs",
         At::line,
         "host: h, framing: rtu, length_tolerance: true",
         {"host: h, framing: tcp, length_tolerance: true", "host: h, framing: rtu"}},
        {"field.needs",
         At::line,
         "host: h, idle_close: 1s",
         {"host: h, idle_close: 1s, connection: on_demand", "host: h"}},
        {"line.tls", At::instrument, "transport: tls", {"transport: serial"}},
        {"line.port_missing", At::line, "framing: rtu", {"framing: rtu, port: /dev/ttyUSB0"}},
        {"field.no_effect_default",
         At::output,
         "brokers: [mqtt://b], backlog: array",
         {"brokers: [mqtt://b]"}},
        {"field.without_effect",
         At::line,
         "transport: tcp, host: h, baud: 9600",
         {"transport: tcp, host: h"}},
        {"backoff.limit", At::device, "backoff: {first: 2s, limit: 1s}", {"backoff: {first: 2s, limit: 2s}"}},
        {"round_trip.usual",
         At::device,
         "round_trip: {longest: 3ms, usual: 4ms, exchanges: 100}",
         {"round_trip: {longest: 3ms, usual: 3ms, exchanges: 100}"}},
        {"device.timeout_short",
         At::device,
         "turnaround: 20ms, response_timeout: 10ms",
         {"turnaround: 20ms, response_timeout: 20ms", "turnaround: 20ms"}},
        {"strategy.grouping_off",
         At::device,
         "group_requests: false, strategy: classic",
         {"group_requests: true, strategy: classic", "group_requests: false"}},
        // variables
        {"variable.address_missing",
         At::variable,
         "{name: V, type: int, read: 3}",
         {"{name: V, type: int, register: 0, read: 3}", "{name: V, type: int, reference: \"40001\"}"}},
        {"variable.address_twice",
         At::variable,
         "{name: V, type: bool, register: 1, coil: 1, read: 1}",
         {"{name: V, type: bool, register: 1, bit: 0, read: 1}", "{name: V, type: bool, coil: 1, read: 1}"}},
        {"variable.area_missing",
         At::variable,
         "{name: V, type: int, register: 1}",
         {"{name: V, type: int, register: 1, read: 3}", "{name: V, type: int, register: 1, write: 6}"}},
        {"variable.no_traffic",
         At::variable,
         "{name: V, type: int, register: 1, area: holding_register, read: none, write: none}",
         {"{name: V, type: int, register: 1, read: 3}",
          "{name: V, type: int, register: 1, area: holding_register, read: none, write: none, used: false}"}},
        {"variable.type_area",
         At::variable,
         "{name: V, type: int, register: 1, area: coil}",
         {"{name: V, type: bool, register: 1, bit: 0, area: coil, read: 1}",
          "{name: V, type: int, register: 1, read: 3}"}},
        {"variable.function_area",
         At::variable,
         "{name: V, type: bool, register: 1, bit: 0, area: coil, read: 3}",
         {"{name: V, type: bool, register: 1, bit: 0, area: coil, read: 1}",
          "{name: V, type: bool, register: 1, bit: 0, area: holding_register, read: 3}"}},
        {"variable.overlaid_areas",
         At::variable,
         "{name: V, type: int, register: 1, read: 4, write: 0x10}",
         {"{name: V, type: int, register: 1, read: 3, write: 0x10}",
          "{name: V, type: int, register: 1, read: 4, write: none}"}},
        {"variable.single_register",
         At::variable,
         "{name: V, type: float, register: 1, read: 3, write: 6}",
         {"{name: V, type: float, register: 1, read: 3, write: 0x10}"}},
        {"variable.bit_write",
         At::variable,
         "{name: V, type: bool, register: 1, bit: 2, read: 3, write: 6}",
         {"{name: V, type: bool, register: 1, bit: 2, read: 3, write: none}",
          "{name: V, type: uint16, register: 1, read: 3, write: 6}"}},
        {"variable.area_not_offered", At::device, "offers: {coil: [0]}", {"offers: [0..9]"}},
        {"variable.not_offered", At::device, "offers: [5..9]", {"offers: [0..9]", "offers: [0, 1, 5..9]"}},
        {"variable.bit_assumed",
         At::variable,
         "{name: V, type: bool, register: 1, read: 3}",
         {"{name: V, type: bool, register: 1, bit: 0, read: 3}", "{name: V, type: bool, coil: 16, read: 1}"}},
        {"variable.coil_assumed",
         At::variable,
         "{name: V, type: bool, register: 17, read: 1}",
         {"{name: V, type: bool, coil: 17, read: 1}",
          "{name: V, type: bool, register: 17, bit: 0, read: 1}"}},
        {"variable.discrete_input_assumed",
         At::variable,
         "{name: V, type: bool, register: 5, read: 2}",
         {"{name: V, type: bool, coil: 5, read: 2}", "{name: V, type: bool, register: 5, bit: 0, read: 2}"}},
        {"variable.bit_type",
         At::variable,
         "{name: V, type: int, register: 1, bit: 2, read: 3}",
         {"{name: V, type: int, register: 1, read: 3}",
          "{name: V, type: bool, register: 1, bit: 2, read: 3}"}},
        {"variable.coil_area",
         At::variable,
         "{name: V, type: bool, coil: 1, read: 3}",
         {"{name: V, type: bool, coil: 1, read: 1}", "{name: V, type: bool, register: 1, bit: 0, read: 3}"}},
        {"variable.beyond_end",
         At::variable,
         "{name: V, type: float, register: 65535, read: 3}",
         {"{name: V, type: float, register: 65534, read: 3}",
          "{name: V, type: int, register: 65535, read: 3}"}},
        {"variable.needs_read",
         At::variable,
         "{name: V, type: int, register: 1, write: 6, read: none, read_trigger: go}",
         {"{name: V, type: int, register: 1, write: 6, read: 3, read_trigger: go}",
          "{name: V, type: int, register: 1, write: 6, read: none}"}},
        {"variable.needs_write",
         At::variable,
         "{name: V, type: int, register: 1, read: 3, verify: true}",
         {"{name: V, type: int, register: 1, read: 3, write: 6, verify: true}",
          "{name: V, type: int, register: 1, read: 3}"}},
        {"variable.length_type",
         At::variable,
         "{name: V, type: int, register: 1, read: 3, length: 2}",
         {"{name: V, type: int, register: 1, read: 3}",
          "{name: V, type: string, register: 1, read: 3, length: 2}"}},
        {"variable.length_missing",
         At::variable,
         "{name: V, type: string, register: 1, read: 3}",
         {"{name: V, type: string, register: 1, read: 3, length: 2}"}},
        {"variable.scale_zero",
         At::variable,
         "{name: V, type: int, register: 1, read: 3, scale: 0}",
         {"{name: V, type: int, register: 1, read: 3, scale: 1}"}},
        {"variable.scale_type",
         At::variable,
         "{name: V, type: bool, register: 1, bit: 1, read: 3, scale: 2}",
         {"{name: V, type: bool, register: 1, bit: 1, read: 3}"}},
        {"variable.write_range_malformed",
         At::variable,
         "{name: V, type: int, register: 1, write: 6, write_range: 5}",
         {"{name: V, type: int, register: 1, write: 6, write_range: 0..120}",
          "{name: V, type: int, register: 1, write: 6, write_range: -5.5..40, scale: 0.1}",
          "{name: V, type: int, register: 1, write: 6, write_range: 0..}",
          "{name: V, type: int, register: 1, write: 6, write_range: ..120}"}},
        {"variable.deadline_without_period",
         At::variable,
         "{name: V, type: int, register: 1, read: 3, period: 0, deadline: 1s}",
         {"{name: V, type: int, register: 1, read: 3, period: 1s, deadline: 1s}",
          "{name: V, type: int, register: 1, read: 3, period: 0}"}},
        {"reference.malformed",
         At::variable,
         "{name: V, type: int, reference: \"4\"}",
         {"{name: V, type: int, reference: \"40108\"}"}},
        {"key.twice", At::device, "slave_id: 2", {"comment: 2"}},
        {"address.is_reference",
         At::variable,
         "{name: V, type: int, register: 400001, read: 0x03}",
         {"{name: V, type: int, reference: 400001, read: 0x03}"}},
        {"words.malformed",
         At::variable,
         "{name: V, type: int, register: 0, read: 0x03, enumeration: {off: 0}}",
         {"{name: V, type: int, register: 0, read: 0x03, enumeration: {0: off}}"}},
        {"words.twice",
         At::variable,
         "{name: V, type: int, register: 0, read: 0x03, enumeration: {1: on, 0x1: off}}",
         {"{name: V, type: int, register: 0, read: 0x03, enumeration: {1: on}}"}},
        {"words.type",
         At::variable,
         "{name: V, type: float, register: 0, read: 0x03, bits: {0: pump}}",
         {"{name: V, type: float, register: 0, read: 0x03}",
          "{name: V, type: int, register: 0, read: 0x03, bits: {0: pump}}"}},
        {"mirror.empty", At::unit, "mirror: {area: coil}", {"mirror: {area: holding_register}"}},
        {"mirror.overlap",
         At::unit,
         "mirror: {first: 0}, banks: [{area: holding_register, items: [0..9]}]",
         {"mirror: {first: 10}, banks: [{area: holding_register, items: [0..9]}]"}},
        {"mirror.beyond_end",
         At::project,
         "takt: 1\nlines: [{name: L, port: p, devices: [{name: D, address: 1, variables: [{name: V, type: "
         "float, register: 0, read: 3}]}]}]\nservers: [{name: S, listen: '*', units: [{address: 1, mirror: "
         "{first: 65535}}]}]\n",
         {"takt: 1\nlines: [{name: L, port: p, devices: [{name: D, address: 1, variables: [{name: V, type: "
          "float, register: 0, read: 3}]}]}]\nservers: [{name: S, listen: '*', units: [{address: 1, mirror: "
          "{first: 65534}}]}]\n"}},
        {"address.like_reference",
         At::variable,
         "{name: V, type: int, register: 40001, read: 3}",
         {"{name: V, type: int, reference: 40001}"}},
        {"address.is_reference",
         At::variable,
         "{name: V, type: int, register: 400001, read: 3}",
         {"{name: V, type: int, reference: 400001}"}},
        {"default.out_of_range",
         At::variable,
         "{name: V, type: int, register: 1, read: 3, default: 99999}",
         {"{name: V, type: int, register: 1, read: 3, default: 9}",
          "{name: V, type: uint32, register: 1, read: 3, default: 99999}"}},
        {"default.too_long",
         At::variable,
         "{name: V, type: string, length: 1, register: 1, read: 3, default: abc}",
         {"{name: V, type: string, length: 1, register: 1, read: 3, default: ab}",
          "{name: V, type: string, length: 2, register: 1, read: 3, default: abc}"}},
        {"byte_order.unknown",
         At::variable,
         "{name: V, type: int, register: 1, read: 3, byte_order: 2413}",
         {"{name: V, type: int, register: 1, read: 3, byte_order: 2143}",
          "{name: V, type: int, register: 1, read: 3, byte_order: CDAB}"}},
        {"byte_order.type",
         At::variable,
         "{name: V, type: float, register: 1, read: 3, byte_order: 12}",
         {"{name: V, type: float, register: 1, read: 3, byte_order: 2143}"}},
        {"byte_order.contradiction",
         At::variable,
         "{name: V, type: float, register: 1, read: 3, byte_order: 2143, high_byte_first: false}",
         {"{name: V, type: float, register: 1, read: 3, byte_order: 2143}",
          "{name: V, type: float, register: 1, read: 3, high_byte_first: false}",
          "{name: V, type: float, register: 1, read: 3, byte_order: 2143, high_byte_first: true}"}},
        // servers
        {"bank.twice",
         At::unit,
         "banks: [{area: coil, items: [0]}, {area: coil, items: [1]}]",
         {"banks: [{area: coil, items: [0, 1]}]"}},
        {"bank.overlay_bits",
         At::unit,
         "banks: [{area: holding_register, items: [0]}, {area: input_register, items: [0], overlay: "
         "holding_register}]",
         {"banks: [{area: holding_register, items: [0]}, {area: input_register, items: [0]}]"}},
        {"bank.retain_outside",
         At::unit,
         "banks: [{area: coil, items: [0], retain: [1]}]",
         {"banks: [{area: coil, items: [0], retain: [0]}]",
          "banks: [{area: coil, items: [0..1], retain: [1]}]"}},
        {"bank.read_only_outside",
         At::unit,
         "banks: [{area: holding_register, items: [0], read_only: [1]}]",
         {"banks: [{area: holding_register, items: [0], read_only: [0]}]",
          "banks: [{area: holding_register, items: [0..1], read_only: [1]}]"}},
        {"bank.overlay_outside",
         At::unit,
         "banks: [{area: coil, items: [0..99], overlay: holding_register}, {area: holding_register, items: "
         "[0]}]",
         {"banks: [{area: coil, items: [0..99], overlay: holding_register}, {area: holding_register, items: "
          "[0..9]}]",
          "banks: [{area: coil, items: [0..9], overlay: holding_register}, {area: holding_register, items: "
          "[0]}]"}},
        {"bank.missing",
         At::unit,
         "banks: [{area: coil, items: [0]}], variables: [{name: A, type: int, area: holding_register, "
         "register: 0}]",
         {"banks: [{area: coil, items: [0]}, {area: holding_register, items: [0]}], variables: [{name: A, "
          "type: int, area: holding_register, register: 0}]"}},
        {"number.twice",
         At::unit,
         "banks: [], files: [{number: 1, records: 1}, {number: 1, records: 1}]",
         {"banks: [], files: [{number: 1, records: 1}, {number: 2, records: 1}]"}},
        {"limits.reversed",
         At::unit,
         "banks: [{area: holding_register, items: [0]}], limits: [{registers: [0], least: 2, greatest: 1}]",
         {"banks: [{area: holding_register, items: [0]}], limits: [{registers: [0], least: 1, greatest: "
          "2}]"}},
        {"limits.outside",
         At::unit,
         "banks: [{area: holding_register, items: [0]}], limits: [{registers: [6], least: 1, greatest: 2}]",
         {"banks: [{area: holding_register, items: [0]}], limits: [{registers: [0], least: 1, greatest: 2}]",
          "banks: [{area: holding_register, items: [0..6]}], limits: [{registers: [6], least: 1, greatest: "
          "2}]"}},
        {"variable.outside_bank",
         At::served,
         "{name: A, type: int, area: holding_register, register: 10}",
         {"{name: A, type: int, area: holding_register, register: 9}"}},
        {"variable.overlap",
         At::served,
         "{name: A, type: int, area: holding_register, register: 0}, {name: B, type: int, area: "
         "holding_register, register: 0}",
         {"{name: A, type: int, area: holding_register, register: 0}, {name: B, type: int, area: "
          "holding_register, register: 1}",
          "{name: A, type: int, area: holding_register, register: 0}, {name: B, type: int, area: "
          "holding_register, register: 0, used: false}"}},
        {"group.one_of",
         At::served,
         "{name: A, type: int, area: holding_register, register: 0, source: {}}",
         {"{name: A, type: int, area: holding_register, register: 0, source: {constant: 1}}"}},
        {"source.unknown",
         At::served,
         "{name: A, type: int, area: holding_register, register: 0, source: {variable: W}}",
         {"{name: A, type: int, area: holding_register, register: 0, source: {variable: V}}"}},
        {"source.not_writable",
         At::served,
         "{name: A, type: int, area: holding_register, register: 0, writes_to: {variable: V}}",
         {"{name: A, type: int, area: holding_register, register: 0}"}},
        {"source.type",
         At::served,
         "{name: A, type: string, length: 2, area: holding_register, register: 0, source: {variable: V}}",
         {"{name: A, type: int, area: holding_register, register: 0, source: {variable: V}}"}},
        {"command.empty",
         At::served,
         "{name: A, type: int, area: holding_register, register: 0, source: {command: {run: []}}}",
         {"{name: A, type: int, area: holding_register, register: 0, source: {command: {run: [program, "
          "argument]}}}"}},
        {"line.unknown",
         At::server,
         "- {name: S, listen: '*', relay: [{line: M}]}",
         {"- {name: S, listen: '*', relay: [{line: L}]}"}},
        {"peer.malformed",
         At::server,
         "- {name: S, listen: '*', access: [{rule: deny, peers: [1.2.3]}], relay: [{line: L}]}",
         {"- {name: S, listen: '*', access: [{rule: deny, peers: [1.2.3.4]}], relay: [{line: L}]}"}},
        // outputs
        {"output.name",
         At::output,
         "brokers: [mqtt://b]}\n- {name: Cloud A, transport: history",
         {"brokers: [mqtt://b]}\n- {name: cloud_a, transport: history"}},
        {"output.password",
         At::output,
         "brokers: [mqtts://b], user: u, password: x",
         {"brokers: [mqtts://b], user: u, password_file: broker.secret",
          "brokers: [mqtts://b], user: u, password_env: BROKER_PASSWORD"}},
        {"output.broker_scheme",
         At::output,
         "brokers: [broker.example:8883]",
         {"brokers: [mqtts://broker.example:8883]"}},
        {"output.broker_scheme", At::output, "brokers: [https://b]", {"brokers: [mqtts://b:8883]"}},
        {"output.broker_user", At::output, "brokers: [mqtt://u:p@b]", {"brokers: [mqtt://b:1883]"}},
        {"output.broker_malformed",
         At::output,
         "brokers: [mqtt://b/topic]",
         {"brokers: [mqtts://broker.example:8883]"}},
        {"output.never",
         At::output,
         "brokers: [mqtt://b], on_change: false",
         {"brokers: [mqtt://b]", "brokers: [mqtt://b], on_change: false, period: 10s"}},
        {"output.unknown",
         At::output,
         "brokers: [mqtt://b], devices: [E]",
         {"brokers: [mqtt://b], devices: [D]", "brokers: [mqtt://b]"}},
        {"output.not_writable",
         At::output,
         "brokers: [mqtt://b], commands: [V]",
         {"brokers: [mqtt://b], commands: [W]", "brokers: [mqtt://b]"}},
        {"output.select_empty",
         At::output,
         "brokers: [mqtt://b], select: [{variables: ['*']}, {variables: [V]}]",
         {"brokers: [mqtt://b], select: [{variables: [V]}, {variables: ['*']}]",
          "brokers: [mqtt://b], select: [{variables: ['*']}]"}},
        {"output.retain_partial",
         At::output,
         "brokers: [mqtt://b], message: device, retain: true",
         {"brokers: [mqtt://b], message: variable, retain: true",
          "brokers: [mqtt://b], message: device, retain: true, on_change: false, period: 10s"}},
        {"output.quota_short",
         At::output,
         "brokers: [mqtt://b], quota_mb: 32, period: 100ms",
         {"brokers: [mqtt://b], quota_mb: 97, period: 100ms",
          "brokers: [mqtt://b], quota_mb: 32, period: 1s"}},
        {"topic.unknown_part",
         At::output,
         "brokers: [mqtt://b], topic: 'a/{name}/{variable}'",
         {"brokers: [mqtt://b], topic: 'a/{line}/{variable}'"}},
        {"topic.shared",
         At::output,
         "brokers: [mqtt://b], topic: 'a/{device}'",
         {"brokers: [mqtt://b], topic: 'a/{device}/{variable}'",
          "brokers: [mqtt://b], topic: 'a/{device}', message: device, retain: false"}},
        {"topic.variable",
         At::output,
         "brokers: [mqtt://b], topic: 'a/{variable}', message: device",
         {"brokers: [mqtt://b], topic: a, message: device",
          "brokers: [mqtt://b], topic: 'a/{variable}', message: variable"}},
        {"topic.reserved",
         At::output,
         "brokers: [mqtt://b], control_topic: a, topic: 'a/set/{variable}'",
         {"brokers: [mqtt://b], control_topic: a, topic: 'a/{device}/{variable}'",
          "brokers: [mqtt://b], topic: 'a/set/{variable}'"}},
        {"server.listen_twice",
         At::server,
         "- {name: S, listen: '*', relay: [{line: L}]}\n- {name: T, listen: '*', relay: [{line: L}]}",
         {"- {name: S, listen: '*', relay: [{line: L}]}\n- {name: T, listen: '*', tcp_port: 1502, relay: "
          "[{line: L}]}"}},
    };
    return kCases;
}

struct Judged {
    std::set<std::string> codes;
    bool accepted = true;
};

Judged judged(const std::string& text) {
    const auto loaded = file::load_text("case.yaml", text);
    Judged made{.accepted = loaded.readable};
    auto findings = loaded.findings;
    for (const auto& finding : model::interpret(loaded.document).findings) findings.push_back(finding);
    for (const auto& finding : findings) {
        made.codes.insert(finding.code);
        made.accepted = made.accepted && finding.severity != model::Severity::error;
    }
    return made;
}

TEST(Advice, FollowedLiterallyRemovesItsFinding) {
    for (const Case& each : cases()) {
        SCOPED_TRACE(each.code);
        const auto broken = project_of(each.at, each.broken);
        EXPECT_TRUE(judged(broken).codes.contains(each.code)) << broken;
        EXPECT_FALSE(each.fixed.empty());
        for (const char* const text : each.fixed) {
            const auto fixed = project_of(each.at, text);
            const auto left = judged(fixed);
            EXPECT_FALSE(left.codes.contains(each.code)) << fixed;
            EXPECT_TRUE(left.accepted) << fixed << *left.codes.begin();
        }
    }
}

TEST(Advice, IsOfARule) {
    const auto codes = model::finding_codes();
    const std::set<std::string_view> rules(codes.begin(), codes.end());
    for (const Case& each : cases()) EXPECT_TRUE(rules.contains(each.code)) << each.code;
}

}  // namespace advice_test
}  // namespace takt
