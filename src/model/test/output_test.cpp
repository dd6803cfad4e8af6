#include "takt/model/output.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "findings_text.hpp"
#include "flow.hpp"
#include "takt/model/findings.hpp"
#include "takt/model/output_remedies.hpp"

namespace takt::model {
namespace output_test {

using namespace test;
using namespace std::chrono_literals;

/// A text with " for each '.
std::string with_quotes(std::string text) {
    std::ranges::replace(text, '\'', '"');
    return text;
}

/// Two devices on a line, two locals.
constexpr std::string_view kProject =
    "{takt: 1, lines: [{name: L1, transport: tcp, host: h, devices: ["
    "{name: Meter, address: 1, variables: ["
    "{name: Power1, type: float, register: 10, read: 3, tags: [energy, a-1]}, "
    "{name: Power2, type: float, register: 12, read: 3, tags: [energy]}, "
    "{name: Alarm, type: bool, coil: 3, read: 1}, "
    "{name: Spare, type: int, register: 1, read: 3, used: false}]}, "
    "{name: Pump, address: 2, variables: ["
    "{name: Setpoint, type: int16, register: 5, read: 3, write: 0x10, tags: [энергия]}, "
    "{name: Flow, type: int16, register: 6, read: 3}]}]}], "
    "locals: [{name: go, type: bool}, {name: level, type: int}], outputs: [";

Checked with_outputs(std::string_view outputs) {
    return interpret(
        {.files = {"p.yaml"}, .root = flow(with_quotes(std::string(kProject).append(outputs).append("]}")))});
}

/// An output to a broker with further keys.
Checked with_keys(std::string_view keys) {
    std::string output = "{name: cloud, transport: mqtt, brokers: [mqtts://b]";
    if (!keys.empty()) output.append(", ").append(keys);
    return with_outputs(output + "}");
}

std::string findings_of(std::string_view keys) {
    return findings_text(with_keys(keys));
}

/// The names of an output's values, with the number of their selection where there are several.
std::string values_of(const Checked& checked) {
    std::string all;
    const auto& output = checked.project.outputs.at(0);
    for (const auto& [subject, selection, topic] : output.values) {
        const auto* const polled = std::get_if<PolledIndex>(&subject);
        if (!all.empty()) all += ' ';
        all += polled == nullptr ? checked.project.locals.at(std::get<LocalIndex>(subject)).name
                                 : checked.project.lines.at(polled->line)
                                       .devices.at(polled->device)
                                       .variables.at(polled->variable)
                                       .name;
        if (output.selections.size() > 1) all += ':' + std::to_string(selection);
    }
    return all;
}

TEST(Output, DefaultsAreComplete) {
    const auto checked = with_keys("");
    EXPECT_EQ(findings_text(checked), "");
    const auto& output = checked.project.outputs.at(0);
    EXPECT_EQ(output.name, "cloud");
    EXPECT_EQ(output.transport, OutputTransport::mqtt);
    EXPECT_EQ(output.mqtt.brokers, (std::vector<Broker>{{.host = "b", .port = 8883, .tls = true}}));
    EXPECT_EQ(output.mqtt.version, MqttVersionChoice::automatic);
    EXPECT_EQ(output.mqtt.keep_alive, 30s);
    EXPECT_EQ(output.mqtt.backoff, Backoff{});
    EXPECT_EQ(output.mqtt.nearby_limit, 10s);
    EXPECT_EQ(output.mqtt.in_flight, 64);
    EXPECT_EQ(output.mqtt.round_trip, 0s);
    EXPECT_EQ(output.mqtt.backlog, Backlog::single);
    ASSERT_EQ(output.selections.size(), 1U);
    EXPECT_EQ(output.selections[0].policy, SamplingPolicy{});
    EXPECT_EQ(output.selections[0].message, MessageScope::variable);
    EXPECT_TRUE(output.selections[0].retain);
    EXPECT_EQ(values_of(checked), "Power1 Power2 Alarm Setpoint Flow") << "used variables, no locals";
    EXPECT_EQ(output.values.at(0).topic, "takt/cloud/Meter/Power1");
    EXPECT_EQ(output.mqtt.control_topic, "takt/cloud");
    EXPECT_TRUE(output.commandable.empty());
    EXPECT_EQ(output.command_expiry, 10s);
    EXPECT_EQ(output.journal.quota, std::uint64_t{4096} << 20U);
    EXPECT_EQ(output.journal.retention, 168h);
    EXPECT_EQ(output.journal.buffer, std::uint64_t{8} << 20U);
    EXPECT_EQ(output.journal.directory, "");
}

TEST(Output, EveryKeyIsRead) {
    const auto checked = with_outputs(
        "{name: c-1_x, transport: mqtt, brokers: ['mqtts://b.example', 'mqtt://192.168.1.5:1884', "
        "'mqtt://[fe80::1]'], version: 3.1.1, client_id: plant 1, user: u, password_env: SECRET, "
        "ca_file: ca.pem, certificate_file: c.pem, key_file: k.pem, alpn: mqtt, keep_alive: 18h, "
        "backoff: {first: 2s, limit: 5s}, in_flight: 1, round_trip: 1ms, backlog: array, control_topic: "
        "'x/{output}/', topic: 'p/{line}/{device}/{variable}', retain: false, "
        "on_change: true, period: 10s, "
        "dead_band: 0.5, heartbeat: 5s, bad_quality: skip, commands: [Setpoint, 'g*'], command_expiry: 1h, "
        "quota_mb: 32, retention: 7d, buffer_mb: 1, directory: j}, "
        "{name: local, transport: history, retention: 30d, quota_mb: 2048}");
    EXPECT_EQ(findings_text(checked), "?output.password_plain password_env=SECRET");
    const auto& output = checked.project.outputs.at(0);
    EXPECT_EQ(output.mqtt, (MqttSettings{.brokers = {{.host = "b.example", .port = 8883, .tls = true},
                                                     {.host = "192.168.1.5", .port = 1884},
                                                     {.host = "fe80::1", .port = 1883}},
                                         .version = MqttVersionChoice::v3_1_1,
                                         .client_id = "plant 1",
                                         .user = "u",
                                         .password_env = "SECRET",
                                         .ca_file = "ca.pem",
                                         .certificate_file = "c.pem",
                                         .key_file = "k.pem",
                                         .alpn = "mqtt",
                                         .keep_alive = 18h,
                                         .backoff = {.first = 2s, .limit = 5s},
                                         .nearby_limit = 5s,
                                         .in_flight = 1,
                                         .round_trip = 1ms,
                                         .backlog = Backlog::array,
                                         .control_topic = "x/c-1_x"}));
    EXPECT_EQ(output.selections.at(0).policy,
              (SamplingPolicy{.period = 10s, .heartbeat = 5s, .dead_band = 0.5, .skip_bad = true}));
    EXPECT_FALSE(output.selections[0].retain);
    EXPECT_EQ(output.values.at(0).topic, "p/L1/Meter/Power1");
    EXPECT_EQ(output.commandable, (std::vector<OutputSubject>{LocalIndex{0}, PolledIndex{0, 1, 0}}));
    EXPECT_EQ(output.command_expiry, 1h);
    EXPECT_EQ(output.journal, (JournalSettings{.quota = std::uint64_t{32} << 20U,
                                               .retention = 168h,
                                               .buffer = std::uint64_t{1} << 20U,
                                               .directory = "j"}));
    const auto& history = checked.project.outputs.at(1);
    EXPECT_EQ(history.transport, OutputTransport::history);
    EXPECT_EQ(history.journal.retention, 720h);
    EXPECT_EQ(history.values.size(), 5U);
    EXPECT_EQ(history.values.at(0).topic, "");
    EXPECT_TRUE(checked.project.lines[0].devices[1].variables[0].written_by_clients);
    EXPECT_FALSE(checked.project.lines[0].devices[1].variables[1].written_by_clients);
}

TEST(Output, ValuesAreSelectedByNameDeviceAndTag) {
    const Case cases[] = {
        {"variables: ['*']", "go level Power1 Power2 Alarm Setpoint Flow"},
        {"variables: ['Power?', go]", "go Power1 Power2"},
        {"devices: [Pump]", "Setpoint Flow"},
        {"devices: ['L1/M*']", "Power1 Power2 Alarm"},
        {"tags: [energy]", "Power1 Power2"},
        {"tags: [a-1, 'эн*']", "Power1 Setpoint"},
        {"variables: ['*1', Flow], devices: [Meter]", "Power1"},
        {"variables: [system.uptime, Flow]", "system.uptime Flow"},
        {"select: [{variables: ['Power*'], period: 1s}, {variables: ['*']}]",
         "go:1 level:1 Power1:0 Power2:0 Alarm:1 Setpoint:1 Flow:1"},
        {"devices: [Meter], select: [{tags: [a-1]}, {variables: ['P*', Alarm]}]",
         "Power1:0 Power2:1 Alarm:1"},
    };
    for (const auto& [keys, expected] : cases) {
        const auto checked = with_keys(keys);
        EXPECT_EQ(findings_text(checked), "") << keys;
        EXPECT_EQ(values_of(checked), expected) << keys;
    }
}

TEST(Output, AnEntryInheritsTheKeysOfItsOutput) {
    const auto checked = with_keys(
        "heartbeat: 1min, dead_band: 1, bad_quality: skip, message: device, topic: 'a/{device}', "
        "select: [{tags: [energy], period: 1s}, "
        "{variables: [Flow], heartbeat: 30s, message: variable, topic: 'b/{variable}', bad_quality: "
        "publish}, "
        "{devices: [Pump], period: 10s, on_change: true, retain: true}]");
    EXPECT_EQ(findings_text(checked), "?output.retain_partial retain=true [retain: false]");
    const auto& selections = checked.project.outputs.at(0).selections;
    ASSERT_EQ(selections.size(), 3U);
    EXPECT_EQ(selections[0].policy,
              (SamplingPolicy{
                  .on_change = false, .period = 1s, .heartbeat = 60s, .dead_band = 1, .skip_bad = true}))
        << "with a period changes are no samples unless it is written";
    EXPECT_EQ(selections[1].policy, (SamplingPolicy{.heartbeat = 30s, .dead_band = 1}));
    EXPECT_EQ(selections[2].policy,
              (SamplingPolicy{
                  .on_change = true, .period = 10s, .heartbeat = 60s, .dead_band = 1, .skip_bad = true}));
    EXPECT_FALSE(selections[0].retain) << "one message has only the values that changed";
    EXPECT_TRUE(selections[1].retain);
    EXPECT_TRUE(selections[2].retain);
    EXPECT_EQ(checked.project.outputs[0].values.at(0).topic, "a/Meter");
    EXPECT_EQ(checked.project.outputs[0].values.at(3).topic, "b/Flow");
}

TEST(Output, TopicsOfLocalsHaveNoDevice) {
    const auto checked = with_keys("variables: [go], topic: '{line}/{device}/{variable}'");
    EXPECT_EQ(findings_text(checked), "");
    EXPECT_EQ(checked.project.outputs.at(0).values.at(0).topic, "locals/locals/go");
}

TEST(Output, MistakesOfTheConnectionAreFindings) {
    const Case cases[] = {
        {"name: Cloud 1", "output.name name=Cloud 1 [a-z 0-9 - _]"},
        {"name: abcdefghijklmnopqrstuvwxyz0123456",
         "field.length name=abcdefghijklmnopqrstuvwxyz0123456 "
         "[1..32]"},
        {"transport: mqtts", "field.unknown_word transport=mqtts [mqtt, history]"},
        {"transport: mqtts, keep_alive: 0s",
         "field.unknown_word transport=mqtts [mqtt, history]; field.out_of_range keep_alive=0s "
         "[5s..18h]"},
        {"transport: history", "?field.without_effect brokers="},
        {"brokers: ~",
         "field.missing brokers= [mqtts://HOST, mqtts://HOST:8883, mqtt://192.168.1.5, "
         "mqtt://[::1]:1883]"},
        {"brokers: []", "field.empty brokers="},
        {"brokers: mqtt://b", "field.not_a_list brokers=mqtt://b"},
        {"client_id: ''", "field.length client_id= [1..256]"},
        {"user: u, password: geheim", "output.password password=password"},
        {"user: u, password_file: p, password_env: P", "output.two_passwords password_env=P"},
        {"password_file: p", "field.missing user="},
        {"brokers: [mqtt://b], user: u, password_file: p", "?output.password_plain password_file=p"},
        {"brokers: [mqtt://localhost, 'mqtt://[::1]', mqtt://127.0.0.1], user: u, password_file: p", ""},
        {"key_file: k", "field.missing certificate_file="},
        {"certificate_file: k", "field.missing key_file="},
        {"brokers: [mqtt://b], ca_file: k", "?field.without_effect ca_file=k"},
        {"keep_alive: 4s", "field.out_of_range keep_alive=4s [5s..18h]"},
        {"keep_alive: 30", "duration.no_unit keep_alive=30 [5s..18h]"},
        {"in_flight: 257", "field.out_of_range in_flight=257 [1..256]"},
        {"version: 4", "field.unknown_word version=4 [auto, 5, 3.1.1]"},
        {"quota_mb: 31", "field.out_of_range quota_mb=31 [32..4194304]"},
        {"buffer_mb: 0", "field.out_of_range buffer_mb=0 [1..256]"},
        {"command_expiry: 10s", "?field.without_effect command_expiry=10s"},
        {"command_expiry: 2h, commands: [go]", "field.out_of_range command_expiry=2h [1s..1h]"},
        {"broker: x", "key.unknown broker=broker"},
    };
    for (const auto& [keys, expected] : cases) {
        const auto output = changed(flow("{name: cloud, transport: mqtt, brokers: [mqtts://b]}"),
                                    flow(with_quotes(std::string("{").append(keys).append("}"))));
        auto root = flow(std::string(kProject).append("]}"));
        root.entries.back().value.items.push_back(output);
        auto found = findings_text(interpret({.files = {"p.yaml"}, .root = root}));
        if (found.starts_with("key.unknown")) found = found.substr(0, found.find(" ["));
        EXPECT_EQ(found, expected) << keys;
    }
}

TEST(Output, BrokersAreUrls) {
    const Case cases[] = {
        {"mqtt://b:0", "output.broker_malformed"},
        {"mqtt://b:65536", "output.broker_malformed"},
        {"mqtt://b:x", "output.broker_malformed"},
        {"mqtt://", "output.broker_malformed"},
        {"mqtt://b/topic", "output.broker_malformed"},
        {"mqtt://fe80::1", "output.broker_malformed"},
        {"mqtt://[b]", "output.broker_malformed"},
        {"mqtt://[::1", "output.broker_malformed"},
        {"mqtt://1.2.3", "output.broker_malformed"},
        {"mqtt://256.1.1.1", "output.broker_malformed"},
        {"mqtt://a b", "output.broker_malformed"},
        {"b.example:8883", "output.broker_scheme"},
        {"b.example", "output.broker_scheme"},
        {"ssl://b", "output.broker_scheme"},
        {"ws://b", "output.broker_scheme"},
        {"http://b", "output.broker_scheme"},
        {"mqtts://u:geheim@b", "output.broker_user"},
        {"mqtts://b/", ""},
        {"mqtts://b_1-x.örtlich:1", ""},
    };
    for (const auto& [url, code] : cases) {
        const auto checked =
            with_outputs("{name: o, transport: mqtt, brokers: ['" + std::string(url) + "']}");
        EXPECT_EQ(checked.findings.empty() ? "" : checked.findings[0].code, code) << url;
        for (const auto& finding : checked.findings) {
            EXPECT_EQ(finding.value.find("geheim"), std::string::npos);
            for (const auto& [name, text] : finding.arguments)
                EXPECT_EQ(text.find("geheim"), std::string::npos) << name;
        }
    }
    EXPECT_EQ(
        findings_text(with_outputs("{name: o, transport: mqtt, brokers: ['mqtt://b', 'mqtt://b:1883']}")),
        "?output.broker_twice brokers[1]=mqtt://b:1883 [mqtts://HOST, mqtts://HOST:8883, "
        "mqtt://192.168.1.5, mqtt://[::1]:1883]");
    std::string many;
    for (int i = 0; i < 9; ++i) many += (i == 0 ? "" : ", ") + ("mqtt://b" + std::to_string(i));
    EXPECT_EQ(findings_text(with_outputs("{name: o, transport: mqtt, brokers: [" + many + "]}")),
              "output.many_brokers brokers= [1..8]");
}

TEST(Output, MistakesOfTheSelectionAreFindings) {
    const Case cases[] = {
        {"variables: [Pwer1]", "output.unknown variables[0]=Pwer1"},
        {"variables: [Spare]", "output.unused variables[0]=Spare"},
        {"variables: ['Pwer*', Flow]", "?output.unmatched variables[0]=Pwer*"},
        {"variables: ['Spare*']", "output.empty variables=; ?output.unmatched variables[0]=Spare*"},
        {"variables: [system.uptme]",
         "service.unknown variables[0]=system.uptme "
         "[system.time, system.uptime, system.first_cycle, system.pulse_1s, "
         "system.pulse_1min, system.line.NAME.*, system.device.NAME.*]"},
        {"variables: []", "field.empty variables="},
        {"variables: [Flow, Flow]", "?output.pattern_twice variables[1]=Flow"},
        {"variables: ['F*', Flow, 'F*']", "?output.pattern_twice variables[2]=F*"},
        {"commands: [go, go]", "?output.pattern_twice commands[1]=go"},
        {"variables: [[Flow]]", "field.not_a_value variables[0]="},
        {"devices: [Metr]", "output.unknown devices[0]=Metr"},
        {"tags: [enrgy]", "output.unknown tags[0]=enrgy"},
        {"tags: [energy], devices: [Pump]", "output.empty variables="},
        {"select: []", "field.empty select="},
        {"select: [Flow]", "field.not_a_mapping select[0]=Flow"},
        {"select: [{variables: ['*']}, {variables: [Flow]}]", "?output.select_empty variables="},
        {"on_change: false", "output.never on_change=false"},
        {"select: [{variables: [Flow], on_change: false}]", "output.never on_change=false"},
        {"heartbeat: 0s", "field.out_of_range heartbeat=0s [1s..24h]"},
        {"period: 10s, heartbeat: 10s", "?field.without_effect heartbeat=10s"},
        {"dead_band: -1", "field.out_of_range dead_band=-1 [>= 0]"},
        {"dead_band: 1, variables: [Alarm]", "?field.without_effect dead_band=1"},
        {"dead_band: 1, period: 1s", "?field.without_effect dead_band=1"},
        {"bad_quality: drop", "field.unknown_word bad_quality=drop [publish, skip]"},
        {"topic: 'a/{tag}'", "topic.unknown_part topic=a/{tag} [{output}, {line}, {device}, {variable}]"},
        {"topic: 'a/{device'", "topic.brace topic=a/{device [{output}, {line}, {device}, {variable}]"},
        {"topic: 'a/+/b'", "topic.wildcard topic=a/+/b [{output}, {line}, {device}, {variable}]"},
        {"topic: 'a//{variable}'",
         "topic.empty_level topic=a//{variable} [{output}, {line}, {device}, {variable}]"},
        {"topic: 'a/{device}'", "topic.shared topic=a/{device}"},
        {"topic: 'a/{device}', message: request", ""},
        {"topic: a, message: device", ""},
        {"topic: a, message: device, retain: true, period: 1s", "topic.shared topic=a"},
        {"message: device, retain: true", "?output.retain_partial retain=true [retain: false]"},
        {"message: request, retain: true, period: 1s, on_change: true",
         "?output.retain_partial retain=true [retain: false]"},
        {"message: device, retain: true, period: 1s", ""},
        {"topic: 'a/{variable}', message: device", "topic.variable topic=a/{variable}"},
        {"control_topic: 'c/{device}'", "topic.unknown_part control_topic=c/{device} [{output}]"},
        {"control_topic: 'c/#'", "topic.wildcard control_topic=c/# [{output}]"},
        {"control_topic: takt, topic: 'takt/set/{variable}'", "topic.reserved topic=takt/set/{variable}"},
        {"control_topic: takt, topic: takt/gap, variables: [Flow]", "topic.reserved topic=takt/gap"},
        {"control_topic: takt, topic: 'takt/gaps/{variable}'", ""},
        {"control_topic: takt/x, topic: 'takt/{variable}/state'", ""},
        {"commands: [Flow]", "output.not_writable commands[0]=Flow"},
        {"commands: ['F*']", "?output.none_writable commands[0]=F*"},
        {"commands: [Setpont]", "output.unknown commands[0]=Setpont"},
        {"commands: ['X*']", "?output.unmatched commands[0]=X*"},
        {"commands: [system.uptime]", "service.read_only commands[0]=system.uptime"},
        {"commands: ['*']", ""},
    };
    for (const auto& [keys, expected] : cases) EXPECT_EQ(findings_of(keys), expected) << keys;
}

TEST(Output, SeveralOutputsDoNotDisturbEachOther) {
    EXPECT_EQ(findings_text(with_outputs("{name: a, transport: mqtt, brokers: [mqtt://b]}, "
                                         "{name: a, transport: history}")),
              "name.duplicate name=a");
    EXPECT_EQ(findings_text(with_outputs("{name: a, transport: mqtt, brokers: [mqtt://b], client_id: x}, "
                                         "{name: c, transport: mqtt, brokers: [mqtt://b], client_id: x}, "
                                         "{name: d, transport: mqtt, brokers: [mqtt://e], client_id: x}")),
              "output.client_id_twice client_id=x");
    EXPECT_EQ(
        findings_text(with_outputs("{name: a, transport: mqtt, brokers: [mqtt://b]}, "
                                   "{name: c, transport: mqtt, brokers: [mqtt://b], control_topic: takt/a}, "
                                   "{name: d, transport: mqtt, brokers: [mqtt://e], control_topic: takt/a}")),
        "output.control_topic_twice control_topic=takt/a");
}

TEST(Output, AJournalThatADayFillsIsAWarning) {
    // 32 MiB / 24 h: 388 bytes a second. A period has 190: a record, five series, five samples.
    const Case cases[] = {
        {"quota_mb: 32, period: 500ms", ""},
        {"quota_mb: 32, period: 400ms", "?output.quota_short quota_mb=32"},
        {"quota_mb: 32", ""},
        {"quota_mb: 32, period: 1s, on_change: true", "?output.quota_short quota_mb=32"},
        {"quota_mb: 64, period: 1s, on_change: true", ""},
        {"quota_mb: 32, variables: [Flow], period: 1ms", "?output.quota_short quota_mb=32"},
        {"variables: [Flow], period: 1ms", "?output.quota_short quota_mb="},
        {"variables: [Flow], period: 2ms", ""},
    };
    for (const auto& [keys, expected] : cases) EXPECT_EQ(findings_of(keys), expected) << keys;
    const auto checked = with_keys("quota_mb: 32, period: 100ms");
    EXPECT_EQ(checked.findings.at(0).arguments,
              (std::vector<std::pair<std::string, std::string>>{
                  {"output", "cloud"}, {"time", "4 h"}, {"rate", "50"}, {"needed", "157"}}));
    EXPECT_EQ(findings_of("quota_mb: 157, period: 100ms"), "") << "the advice is enough";
    EXPECT_EQ(findings_text(with_outputs("{name: a, transport: history, quota_mb: 32, period: 1ms}")), "")
        << "a history has no broker";
}

// Measured in the segments of runs of 6 s against a broker that is away, with names as Power3_2 of Meter3.
TEST(Output, TheBytesOfTheJournalAreThoseThatWereMeasured) {
    const auto bytes_of_sample = [](int devices, int variables, std::string_view type,
                                    std::string_view keys) {
        std::string text = "{takt: 1, lines: [{name: L1, transport: tcp, host: h, devices: [";
        for (int d = 0; d < devices; ++d) {
            text += "{name: D" + std::to_string(d) + ", address: " + std::to_string(d + 1) +
                    ", poll_period: 20ms, variables: [";
            for (int v = 0; v < variables; ++v)
                text += "{name: V" + std::to_string(d) + "_" + std::to_string(v) +
                        ", type: " + std::string(type) + ", register: " + std::to_string(4 * v) +
                        ", read: 3}, ";
            text += "]}, ";
        }
        text += "]}], outputs: [{name: o, transport: mqtt, brokers: [mqtt://b], " + std::string(keys) + "}]}";
        const auto checked = interpret({.files = {"p.yaml"}, .root = flow(text)});
        EXPECT_EQ(findings_text(checked), "");
        const auto& output = checked.project.outputs.at(0);
        return most_journal_bytes_per_second(checked.project, output) /
               most_samples_per_second(checked.project, output);
    };
    EXPECT_NEAR(bytes_of_sample(17, 5, "int16", "period: 100ms"), 23.8, 1.5);
    EXPECT_NEAR(bytes_of_sample(17, 5, "int16", "period: 1s"), 23.2, 2);
    EXPECT_NEAR(bytes_of_sample(17, 5, "float", "period: 100ms"), 25.9, 1.5);
    EXPECT_NEAR(bytes_of_sample(2, 5, "int16", "period: 10ms"), 28.8, 2.5);
    EXPECT_NEAR(bytes_of_sample(1, 5, "float", "period: 10ms"), 37.8, 2.5);
    EXPECT_NEAR(bytes_of_sample(4, 5, "double", "period: 20ms"), 31.8, 2.5);
    EXPECT_NEAR(bytes_of_sample(2, 5, "int16", ""), 17.9, 4) << "on change";
}

TEST(Output, TheLongestPauseIsShortNearby) {
    const auto pauses_of = [](std::string_view keys) {
        const auto mqtt = with_keys(keys).project.outputs.at(0).mqtt;
        return std::array{mqtt.backoff.first, mqtt.backoff.limit, mqtt.nearby_limit};
    };
    EXPECT_EQ(pauses_of("backoff: 2s"), (std::array<Duration, 3>{2s, 60s, 10s}));
    EXPECT_EQ(pauses_of("backoff: 20s"), (std::array<Duration, 3>{20s, 60s, 20s}));
    EXPECT_EQ(pauses_of("backoff: {limit: 90s}"), (std::array<Duration, 3>{1s, 90s, 90s}));
    EXPECT_EQ(pauses_of("backoff: {limit: 500ms}"), (std::array<Duration, 3>{500ms, 500ms, 500ms}));
    EXPECT_EQ(findings_of("backoff: {first: 2s, limit: 1s}"), "backoff.limit limit=1s [>= 2s]");
    const auto other = with_keys("backoff: {max: 5s}").findings.at(0);
    EXPECT_EQ(other.code, "key.unknown");
    EXPECT_EQ(other.arguments.at(0).second, "limit") << "as other programs call it";
}

TEST(Output, MoreMessagesThanTheWindowTakesAreANote) {
    // Five values: 250 messages a second, 100 of devices.
    const Case cases[] = {
        {"period: 20ms, round_trip: 100ms", "output.falls_behind round_trip=100ms"},
        {"period: 25ms, round_trip: 100ms", ""},
        {"period: 20ms", ""},
        {"period: 20ms, round_trip: 100ms, in_flight: 25", ""},
        {"period: 20ms, round_trip: 100ms, in_flight: 24", "output.falls_behind round_trip=100ms"},
        {"period: 25ms, round_trip: 100ms, in_flight: 10", "output.falls_behind round_trip=100ms"},
        {"period: 20ms, round_trip: 100ms, message: device", ""},
        {"period: 20ms, round_trip: 100ms, backlog: array, retain: false", ""},
        {"period: 20ms, round_trip: 100ms, backlog: array",
         "output.falls_behind round_trip=100ms; ?field.no_effect_default backlog=array"},
        {"period: 20ms, backlog: array, retain: true", "?field.without_effect backlog=array"},
        {"backlog: array, message: device", ""},
        {"backlog: array, select: [{variables: [Flow], retain: false}, {variables: ['*']}]", ""},
        {"backlog: list", "field.unlike_word backlog=list [single, array]"},
        {"round_trip: 61s", "field.out_of_range round_trip=61s [1us..60s]"},
    };
    for (const auto& [keys, expected] : cases) EXPECT_EQ(findings_of(keys), expected) << keys;
    const auto checked = with_keys("period: 20ms, round_trip: 100ms");
    EXPECT_EQ(checked.findings.at(0).severity, Severity::note);
    EXPECT_EQ(checked.findings.at(0).arguments,
              (std::vector<std::pair<std::string, std::string>>{{"output", "cloud"},
                                                                {"rate", "250"},
                                                                {"limit", "200"},
                                                                {"window", "20"},
                                                                {"round_trip", "100ms"},
                                                                {"needed", "25"},
                                                                {"remedies", "array,device,window"}}));
}

TEST(Output, RemediesAreThoseThatTheSettingsLeaveOpen) {
    const std::pair<std::string, std::string> cases[] = {
        {"period: 20ms, message: device, topic: '{device}', retain: false", "array"},
        {"period: 20ms, backlog: array", "retain,device"},
        {"period: 20ms, backlog: array, retain: false", "device"},
        {"period: 20ms, backlog: array, message: device, topic: '{device}', retain: false", ""},
    };
    for (const auto& [keys, remedies] : cases) {
        const auto checked = with_keys(keys);
        const auto& output = checked.project.outputs.at(0);
        const auto with = [&](std::string_view last) {
            return remedies + (remedies.empty() ? "" : ",") + std::string(last);
        };
        EXPECT_EQ(output_remedies(output, 256), with("window")) << keys;
        EXPECT_EQ(output_remedies(output, 257), with("fewer")) << keys;
        EXPECT_EQ(output_remedies(output), with("in_flight")) << keys;
    }
    EXPECT_EQ(output_remedies(with_keys("in_flight: 256").project.outputs.at(0)), "array,device,fewer");
}

TEST(Output, TheRateOfSamplesIsBoundedByPollingPeriodAndHeartbeat) {
    const std::pair<std::string_view, double> cases[] = {
        {"variables: [Flow]", 1},
        {"variables: [go]", 1},
        {"variables: [Flow], heartbeat: 1min", 1},
        {"variables: [Flow], period: 10s", 0.1},
        {"variables: [Flow], period: 10s, on_change: true", 1.1},
        {"variables: [Flow], period: 10s, heartbeat: 2s", 0.6},
    };
    for (const auto& [keys, rate] : cases) {
        const auto checked = with_keys(keys);
        EXPECT_DOUBLE_EQ(most_samples_per_second(checked.project, checked.project.outputs.at(0)), rate)
            << keys;
    }
}

TEST(Output, HistoryTakesNoKeysOfMqtt) {
    EXPECT_EQ(
        findings_text(with_outputs("{name: a, transport: history, topic: x, message: device, retain: true, "
                                   "commands: [go], user: u, select: [{variables: [Flow], topic: x}]}")),
        "?field.without_effect topic=x; ?field.without_effect message=device; "
        "?field.without_effect retain=true; ?field.without_effect commands=; "
        "?field.without_effect user=u; ?field.without_effect topic=x");
}

TEST(Output, AProjectHasOneHistory) {
    EXPECT_EQ(findings_text(with_outputs("{name: a, transport: history, variables: [Flow]}, "
                                         "{name: b, transport: mqtt, brokers: [mqtts://b]}, "
                                         "{name: c, transport: history, variables: [Alarm]}")),
              "output.history_twice transport=history");
}

TEST(Output, TagsAreWords) {
    EXPECT_EQ(findings_text(Changes{.variable = "{tags: [a, b-2, ц_1, a]}"}), "");
    EXPECT_EQ(findings_text(Changes{.variable = "{tags: [a b]}"}), "tag.malformed tags[0]=a b [1..32]");
    EXPECT_EQ(findings_text(Changes{.variable = "{tags: [\"\"]}"}), "tag.malformed tags[0]= [1..32]");
    const auto names = interpret(document({.variable = "{name: ~, tag: Level}"}));
    ASSERT_EQ(names.findings.size(), 1U);
    EXPECT_EQ(names.findings[0].arguments.at(0).second, "name") << "as other programs call it";
    EXPECT_EQ(findings_text(Changes{.variable = "{tags: a}"}), "field.not_a_list tags=a");
    auto source = document({});
    auto& variable =
        source.root.entries[1].value.items[0].entries[3].value.items[0].entries[2].value.items[0];
    variable = changed(variable, flow(with_quotes("{tags: 'a; b,c  d'}")));
    variable.entries.back().value.cell = true;
    const auto checked = interpret(source);
    EXPECT_EQ(findings_text(checked), "");
    EXPECT_EQ(checked.project.lines[0].devices[0].variables[0].tags,
              (std::vector<std::string>{"a", "b", "c", "d"}));
}

TEST(Output, TheJournalIsBesideTheProject) {
    EXPECT_EQ(journal_directory("plant.yaml"), "plant.journal");
    EXPECT_EQ(journal_directory("/etc/takt.d/plant"), "/etc/takt.d/plant.journal");
    EXPECT_EQ(journal_directory("a/.yaml"), "a/.yaml.journal");
}

}  // namespace output_test
}  // namespace takt::model
