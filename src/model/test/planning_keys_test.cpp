// The keys that planning and its guarantees need: the meaning of each, and the finding of each mistake.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "findings_text.hpp"
#include "flow.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/findings.hpp"

namespace takt::model::test {
namespace planning_keys_test {

using namespace std::chrono_literals;

constexpr std::string_view kTcp = "{transport: tcp, host: plc, port: ~}";

Project project(const Changes& changes) {
    return interpret(document(changes)).project;
}

Device device(std::string_view keys, std::string_view of_project = "{}") {
    return project({.project = of_project, .device = keys}).lines.at(0).devices.at(0);
}

/// "0-9 12" of one area.
std::string text(const std::vector<ItemRange>& ranges) {
    std::string all;
    for (const auto [first, last] : ranges) {
        if (!all.empty()) all += ' ';
        all += std::to_string(first);
        if (first != last) all += "-" + std::to_string(last);
    }
    return all;
}

struct Case {
    std::string_view keys;
    std::string_view expected;
};

TEST(PlanningKeys, OfAProject) {
    const Case cases[] = {
        {"{host: {jitter: 1ms, overhead: 200us}}", ""},
        {"{host: {jitter: 0, overhead: 0}}", ""},
        {"{host: {jitter: 2}}", "duration.no_unit jitter=2 [0ms..65535ms]"},
        {"{host: {overhead: 65536ms}}", "field.out_of_range overhead=65536ms [0ms..65535ms]"},
        {"{host: {jiter: 1ms}}", "key.unknown jiter=jiter [jitter, overhead]"},
        {"{host: 1ms}", "field.not_a_group host=1ms [jitter, overhead]"},
        {"{host: [1ms]}", "field.not_a_group host= [jitter, overhead]"},
        {"{host: }", "field.empty host= [jitter, overhead]"},
        {"{host: {jitter: }}", "field.empty jitter= [0ms..65535ms]"},
        {"{faults: {burst: 0, every: 1ms}}", ""},
        {"{faults: {burst: 255, every: 24h}}", ""},
        {"{faults: {burst: 256}}", "field.out_of_range burst=256 [0..255]"},
        {"{faults: {every: 999us}}", "field.out_of_range every=999us [1ms..24h]"},
        {"{faults: {jitter: 1ms}}", "key.elsewhere jitter=jitter [burst, every]"},
        {"{backoff: 1s}", ""},
        {"{backoff: {first: 1s, limit: 1s}}", ""},
        {"{backoff: {first: 2s, limit: 1s}}", "backoff.limit limit=1s [>= 2s]"},
        {"{backoff: 0ms}", "field.out_of_range backoff=0ms [1ms..24h]"},
        {"{backoff: {first: 25h}}", "field.out_of_range first=25h [1ms..24h]"},
        {"{backoff: [1s]}", "field.not_a_value backoff= [1ms..24h]"},
        {"{backoff: {frist: 1s}}", "key.unknown frist=frist [first, limit]"},
    };
    for (const auto& [keys, expected] : cases) EXPECT_EQ(findings_text({.project = keys}), expected) << keys;
}

TEST(PlanningKeys, AreKeptInTheProject) {
    const auto plain = project({});
    EXPECT_EQ(plain.host.jitter, 1ms);
    EXPECT_EQ(plain.host.overhead, 200us);
    EXPECT_FALSE(plain.faults_set);
    EXPECT_EQ(plain.faults.burst, 1);
    EXPECT_EQ(plain.faults.every, 1s);
    const auto given = project(
        {.project = "{host: {jitter: 3ms, overhead: 0}, faults: {burst: 2, every: 5s}, backoff: 90s}"});
    EXPECT_EQ(given.host.jitter, 3ms);
    EXPECT_EQ(given.host.overhead, 0ms);
    EXPECT_TRUE(given.faults_set);
    EXPECT_EQ(given.faults.burst, 2);
    EXPECT_EQ(given.faults.every, 5s);
    const auto one = project({.project = "{faults: {burst: 2}}"});
    EXPECT_TRUE(one.faults_set);
    EXPECT_EQ(one.faults.every, 1s);
}

TEST(PlanningKeys, ARoundTripIsATimeOrWhatWasMeasured) {
    const Case cases[] = {
        {"{round_trip: 2ms}", "?field.without_effect round_trip=2ms"},  // a serial line
        {"{round_trip: {longest: 3ms}}", "field.missing exchanges= [100..1000000000000]"},
        {"{round_trip: {exchanges: 100}}", "field.missing longest= [0ms..65535ms]"},
        {"{round_trip: {longest: 3ms, exchanges: 99}}",
         "field.out_of_range exchanges=99 [100..1000000000000]"},
        {"{round_trip: {longest: 3ms, exchanges: 100, in_flight: 17}}",
         "field.out_of_range in_flight=17 [1..16]"},
        {"{round_trip: {longest: 3ms, usual: 4ms, exchanges: 100}}", "round_trip.usual usual=4ms [<= 3ms]"},
    };
    for (const auto& [keys, expected] : cases) {
        const auto found = findings_text({.device = keys});
        EXPECT_NE(found.find(expected), std::string::npos) << keys << ": " << found;
    }
    const auto given = device("{round_trip: {longest: 3ms, usual: 400us, exchanges: 99000, in_flight: 4}}");
    EXPECT_EQ(given.round_trip, 400us);
    EXPECT_EQ(given.measured_round_trip, (MeasuredRoundTrip{3ms, 400us, 99000, 4}));
    EXPECT_EQ(given.expected_turnaround(), 3ms);
    EXPECT_EQ(given.expected_turnaround(4), 3ms);
    EXPECT_EQ(given.expected_turnaround(5), 6ms) << "as if the fifth one waited for the first four";
    EXPECT_EQ(given.measured_exchanges(), 99000U);
    const auto shortest = device("{round_trip: {longest: 3ms, exchanges: 100}}");
    EXPECT_EQ(shortest.round_trip, 3ms);
    const auto written = device("{turnaround: 5ms, round_trip: {longest: 3ms, exchanges: 100}}");
    EXPECT_EQ(written.expected_turnaround(2), 10ms) << "what is written counts";
    EXPECT_EQ(written.measured_exchanges(), 0U);
    auto learnt = device("{turnaround: learn}");
    learnt.times.measured = {.exchanges = 100, .longest = 5ms};
    EXPECT_EQ(learnt.expected_turnaround(4), 20ms) << "how many were in flight then is not known";
    EXPECT_FALSE(device("{round_trip: 2ms}").measured_round_trip);
    EXPECT_EQ(device("{round_trip: 2ms}").expected_turnaround(), std::nullopt);
}

TEST(PlanningKeys, ABackOffIsFilledUp) {
    struct BackoffCase {
        std::string_view of_project;
        std::string_view of_device;
        Duration first;
        Duration limit;
    };
    const BackoffCase cases[] = {
        {"{}", "{backoff: 5s}", 5s, 60s},
        {"{}", "{backoff: 90s}", 90s, 90s},
        {"{}", "{backoff: {first: 2s, limit: 4s}}", 2s, 4s},
        {"{}", "{backoff: {first: 61s}}", 61s, 61s},
        {"{}", "{backoff: {limit: 30s}}", 1s, 30s},
        {"{}", "{backoff: {limit: 500ms}}", 500ms, 500ms},
        {"{backoff: {first: 3s, limit: 9s}}", "{backoff: 4s}", 4s, 9s},
        {"{backoff: {first: 3s, limit: 9s}}", "{backoff: {limit: 1h}}", 3s, 1h},
    };
    for (const auto& [of_project, of_device, first, limit] : cases) {
        const auto backoff = device(of_device, of_project).backoff;
        ASSERT_TRUE(backoff) << of_device;
        EXPECT_EQ(backoff->first, first) << of_project << of_device;
        EXPECT_EQ(backoff->limit, limit) << of_project << of_device;
    }
    EXPECT_FALSE(device("{}", "{backoff: 5s}").backoff) << "the project's is its own";
    const auto of_project = project({.project = "{backoff: 5s}"}).backoff;
    EXPECT_EQ(of_project.first, 5s);
    EXPECT_EQ(of_project.limit, 60s);
}

TEST(PlanningKeys, OfADevice) {
    const Case cases[] = {
        {"{readable: [7, 0..99, 0-99, 0x10..0x1F, [0, 99], [0x00, 65535]]}", ""},
        {"{readable: [\"0-99\", 0 .. 99, 0 - 99]}", ""},
        {"{no_read: {coil: [1], holding_register: [5..9]}}", ""},
        {"{readable: 7}", "field.not_a_list readable=7"},
        {"{readable: }", "field.empty readable= [0..65535]"},
        {"{readable: []}", "field.empty readable="},
        {"{readable: {coil: 7}}", "field.not_a_list coil=7"},
        {"{readable: {coils: [7]}}",
         "key.unknown coils=coils [coil, discrete_input, input_register, holding_register]"},
        {"{readable: [9..5]}", "range.reversed readable[0]=9..5 [0..65535]"},
        {"{readable: [1, [9, 5]]}", "range.reversed readable[1]=[9, 5] [0..65535]"},
        {"{no_read: [65536]}", "field.out_of_range no_read[0]=65536 [0..65535]"},
        {"{no_read: [0..65536]}", "field.out_of_range no_read[0]=0..65536 [0..65535]"},
        {"{no_read: [-1]}", "field.out_of_range no_read[0]=-1 [0..65535]"},
        {"{no_read: [5--3]}", "field.out_of_range no_read[0]=5--3 [0..65535]"},
        {"{no_read: [99999999999999999999]}",
         "field.out_of_range no_read[0]=99999999999999999999 [0..65535]"},
        {"{no_read: [010]}", "integer.leading_zero no_read[0]=010 [0..65535]"},
        {"{no_read: {input_register: [a..b]}}",
         "range.malformed input_register[0]=a..b [7, 0..99, 0-99, 0x10..0x1F, [0, 99]]"},
        {"{no_read: [1.5]}", "range.malformed no_read[0]=1.5 [7, 0..99, 0-99, 0x10..0x1F, [0, 99]]"},
        {"{no_read: [0..]}", "range.malformed no_read[0]=0.. [7, 0..99, 0-99, 0x10..0x1F, [0, 99]]"},
        {"{no_read: [\"\"]}", "range.malformed no_read[0]= [7, 0..99, 0-99, 0x10..0x1F, [0, 99]]"},
        {"{no_read: [[1, 2, 3, 4]]}",
         "range.malformed no_read[0]=[1, 2, 3, ...] [7, 0..99, 0-99, 0x10..0x1F, [0, 99]]"},
        {"{no_read: [{a: b}]}", "range.malformed no_read[0]={...} [7, 0..99, 0-99, 0x10..0x1F, [0, 99]]"},
        {"{gaps: learn, write_single: never, fc22: true, fc23: true, read_modify_write: true}", ""},
        {"{write_single: always}", "field.unlike_word write_single=always [allowed, only, never]"},
        {"{fc22: 1}", "boolean.malformed fc22=1 [true, false]"},
        {"{fc23: [true]}", "field.not_a_value fc23= [true, false]"},
        {"{read_modify_write: on}", "boolean.malformed read_modify_write=on [true, false]"},
        {"{deadline: 50ms}", ""},
        {"{deadline: 0ms}", "field.out_of_range deadline=0ms [1us..24h]"},
        {"{backoff: {first: 2s, limit: 1s}}", "backoff.limit limit=1s [>= 2s]"},
        {"{in_flight: 4}", "?field.without_effect in_flight=4"},
        {"{in_flight: 1}", ""},
        {"{in_flight: 17}", "field.out_of_range in_flight=17 [1..16]"},
    };
    for (const auto& [keys, expected] : cases) {
        const auto optimal = "{strategy: optimal, " + std::string(keys.substr(1));
        EXPECT_EQ(findings_text({.device = optimal}), expected) << keys;
    }
}

TEST(PlanningKeys, RequestsInFlightNeedTransactionIds) {
    const Case lines[] = {
        {kTcp, ""},
        {"{transport: tls, host: plc, port: ~}", ""},
        {"{transport: simulated, framing: tcp}", ""},
        {"{transport: tcp, host: plc, port: ~, framing: rtu}", "?field.without_effect in_flight=16"},
        {"{transport: simulated}", "?field.without_effect in_flight=16"},
        {"{}", "?field.without_effect in_flight=16"},
    };
    for (const auto& [line, expected] : lines) {
        const Changes changes{.line = line, .device = "{in_flight: 16}"};
        EXPECT_EQ(findings_text(changes), expected) << line;
        EXPECT_EQ(project(changes).lines[0].devices[0].in_flight, expected.contains("in_flight") ? 1 : 16)
            << line;
    }
}

TEST(PlanningKeys, WithoutEffectInOtherStrategies) {
    for (const auto* strategy : {"single", "classic"})
        for (const auto* key :
             {"gaps: learn", "readable: [1]", "no_read: [1]", "write_single: allowed", "fc23: true"}) {
            const auto keys = "{group_requests: true, strategy: " + std::string(strategy) + ", " + key + "}";
            const auto found = interpret(document({.device = keys})).findings;
            ASSERT_EQ(found.size(), 1U) << keys;
            EXPECT_EQ(found[0].code, "field.without_effect") << keys;
            EXPECT_EQ(found[0].arguments[1].second, "strategy: " + std::string(strategy)) << keys;
        }
    for (const auto* key : {"gaps: never", "fc23: false", "fc22: true", "read_modify_write: true"})
        EXPECT_EQ(findings_text({.device = "{strategy: classic, " + std::string(key) + "}"}), "") << key;
}

TEST(PlanningKeys, RangesAreSortedAndMerged) {
    const auto lists = device("{strategy: optimal, readable: [20, 5..9, [0, 3], 10-12, 7, 65535]}").readable;
    for (const auto& area : lists) EXPECT_EQ(text(area), "0-3 5-12 20 65535");
    const auto areas =
        device("{strategy: optimal, no_read: {coil: [3, 4], holding_register: [0x10..0x1F]}}").no_read;
    EXPECT_EQ(text(areas[0]), "3-4");
    EXPECT_EQ(text(areas[1]), "");
    EXPECT_EQ(text(areas[2]), "");
    EXPECT_EQ(text(areas[3]), "16-31");
    EXPECT_EQ(text(device("{strategy: optimal, no_read: [1..2, x, 9..8]}").no_read[0]), "1-2");
}

TEST(PlanningKeys, WhatIsReadableMayBeRead) {
    EXPECT_EQ(device("{strategy: optimal}").gaps, Gaps::never);
    EXPECT_EQ(device("{strategy: optimal, no_read: [1]}").gaps, Gaps::never);
    EXPECT_EQ(device("{strategy: optimal, readable: [1]}").gaps, Gaps::always);
    EXPECT_EQ(device("{strategy: optimal, readable: [1], gaps: never}").gaps, Gaps::never);
    EXPECT_EQ(device("{strategy: optimal, readable: [1], gaps: learn}").gaps, Gaps::learn);
    const auto some = device("{strategy: optimal, readable: {coil: [1]}, no_read: {holding_register: [2]}}");
    EXPECT_EQ(some.gaps, Gaps::always);
    EXPECT_EQ(text(some.no_read[0]), "") << "it is stated for coils";
    EXPECT_EQ(text(some.no_read[2]), "0-65535") << "of input registers nothing is";
    EXPECT_EQ(text(some.no_read[3]), "0-65535");
    const auto stated = device("{strategy: optimal, readable: {coil: [1]}, gaps: always}");
    EXPECT_EQ(text(stated.no_read[2]), "") << "gaps: always was stated for the device";
}

TEST(PlanningKeys, DefaultOfTheStrategy) {
    constexpr std::string_view kGrouped = "{group_requests: true}";
    EXPECT_EQ(device("{}").strategy, Strategy::optimal);
    EXPECT_EQ(device("{}").gaps, Gaps::never);
    EXPECT_EQ(device("{}", "{profile: owen-kc1}").strategy, Strategy::single);
    EXPECT_EQ(device("{group_requests: false}").strategy, Strategy::single);
    EXPECT_EQ(device("{strategy: single}").group_requests, false);
    EXPECT_EQ(device(kGrouped).strategy, Strategy::optimal);
    EXPECT_EQ(device(kGrouped, "{profile: owen-kc1}").strategy, Strategy::classic);
    EXPECT_EQ(device("{group_requests: true, strategy: classic}").strategy, Strategy::classic);
    EXPECT_EQ(device("{strategy: optimal}", "{profile: owen-kc1}").strategy, Strategy::optimal);
    EXPECT_EQ(device("{strategy: optimal}").group_requests, true);
}

TEST(PlanningKeys, WordsOfWritingByOneItem) {
    EXPECT_EQ(device("{strategy: optimal}").write_single, WriteSingle::as_declared);
    EXPECT_EQ(device("{strategy: optimal, write_single: allowed}").write_single, WriteSingle::allowed);
    EXPECT_EQ(device("{strategy: optimal, write_single: only}").write_single, WriteSingle::only);
    EXPECT_EQ(device("{strategy: optimal, write_single: never}").write_single, WriteSingle::never);
}

TEST(PlanningKeys, WhatADeviceCanWrite) {
    struct WriteCase {
        std::string_view device;
        std::string_view variable;
        std::string_view expected;
        std::optional<wire::Function> write;
    };
    using enum wire::Function;
    const WriteCase cases[] = {
        {"{write_single: only}", "{type: float, write: 0x10}", "variable.write_single_only write=0x10 [none]",
         write_multiple_registers},
        {"{write_single: only}", "{type: string, length: 2, write: 0x10}",
         "variable.write_single_only write=0x10 [none]", write_multiple_registers},
        {"{write_single: only}", "{write: 0x10}", "", write_multiple_registers},
        {"{write_single: only}", "{type: bool, bit: 0, read: 1, write: 0x0F}", "", write_multiple_coils},
        {"{write_single: never}", "{write: 0x06}", "", write_single_register},
        {"{write_single: never}", "{type: bool, bit: 0, read: 1, write: 0x05}", "", write_single_coil},
        {"{write_single: allowed}", "{type: float, write: 0x10}", "", write_multiple_registers},
        {"{}", "{type: bool, bit: 3, write: 0x06}", "?variable.bit_write write=0x06 [none]", {}},
        {"{fc22: false}", "{type: bool, bit: 3, write: 0x10}", "?variable.bit_write write=0x10 [none]", {}},
        {"{fc22: true}", "{type: bool, bit: 3, write: 0x06}", "", write_single_register},
        {"{fc22: true}", "{type: bool, bit: 3, write: 0x10}", "", write_multiple_registers},
        {"{read_modify_write: true}", "{type: bool, bit: 3, write: 0x10}", "", write_multiple_registers},
        {"{fc23: true}", "{type: bool, bit: 3, write: 0x10}", "?variable.bit_write write=0x10 [none]", {}},
    };
    for (const auto& [of_device, variable, expected, write] : cases) {
        const auto keys =
            "{strategy: optimal" + (of_device == "{}" ? "}" : ", " + std::string(of_device.substr(1)));
        const Changes changes{.device = keys, .variable = variable};
        EXPECT_EQ(findings_text(changes), expected) << of_device << variable;
        EXPECT_EQ(project(changes).lines[0].devices[0].variables[0].write, write) << of_device << variable;
    }
    EXPECT_EQ(findings_text({.device = "{fc22: true}", .variable = "{type: bool, bit: 3, write: 0x06}"}), "")
        << "in every strategy";
}

TEST(PlanningKeys, AValueLargerThanTheUsersLimit) {
    const Case devices[] = {
        {"{strategy: optimal}", ""},
        {"{strategy: optimal, registers_per_request: 4}", ""},
        {"{strategy: optimal, registers_per_request: 3}", "?variable.read_in_parts type=double"},
        {"{strategy: classic, registers_per_request: 3}", "?variable.larger_than_request type=double"},
        {"{strategy: single, group_requests: true}", ""},
    };
    for (const auto& [keys, expected] : devices)
        EXPECT_EQ(findings_text({.device = keys, .variable = "{type: double}"}), expected) << keys;
    const std::string_view text = "{type: string, length: 17}";
    EXPECT_EQ(findings_text({.device = "{strategy: classic}", .variable = text}),
              "?variable.larger_than_request length=17");
    EXPECT_EQ(findings_text({.device = "{strategy: optimal}", .variable = text}), "");
}

TEST(PlanningKeys, ADeadlineOfADeviceIsThatOfItsVariables) {
    const auto deadline = [](std::string_view keys, std::string_view variable) {
        return project({.device = keys, .variable = variable}).lines[0].devices[0].variables[0].deadline;
    };
    EXPECT_EQ(deadline("{}", "{}"), std::nullopt);
    EXPECT_EQ(deadline("{deadline: 40ms}", "{}"), 40ms);
    EXPECT_EQ(deadline("{deadline: 40ms}", "{deadline: 30ms}"), 30ms);
    EXPECT_EQ(deadline("{deadline: 40ms}", "{period: 0ms}"), std::nullopt);
    EXPECT_EQ(findings_text({.device = "{deadline: 40ms, poll_period: 0ms}"}), "");
    const auto two =
        project({.line = "{devices: [{name: A, address: 1, deadline: 40ms}, {name: B, address: 2, "
                         "variables: [{name: X, type: int, register: 0, read: 3}]}]}"});
    EXPECT_EQ(two.lines[0].devices[1].variables[0].deadline, std::nullopt) << "another device's";
}

TEST(PlanningKeys, RateLimit) {
    const Case variables[] = {
        {"{write: 0x10, write_on_change: true, min_interval: 1ms}", ""},
        {"{write: 0x10, min_interval: 24h, burst: 255}", ""},
        {"{write: 0x10, min_interval: 0ms}", "field.out_of_range min_interval=0ms [1ms..24h]"},
        {"{write: 0x10, min_interval: 10}", "duration.no_unit min_interval=10 [1ms..24h]"},
        {"{write: 0x10, min_interval: 1s, burst: 0}", "field.out_of_range burst=0 [1..255]"},
        {"{write: 0x10, min_interval: 1s, burst: 256}", "field.out_of_range burst=256 [1..255]"},
        {"{write: 0x10, burst: 2}", "burst.alone burst=2 [1ms..24h]"},
        {"{min_interval: 1s}", "variable.needs_write min_interval=1s"},
        {"{write: none, min_interval: 1s, burst: 2}", "variable.needs_write min_interval=1s"},
    };
    for (const auto& [keys, expected] : variables)
        EXPECT_EQ(findings_text({.variable = keys}), expected) << keys;
    const Case locals[] = {
        {"{type: bool, min_interval: 1s}", ""},
        {"{type: bool, min_interval: 1s, burst: 3}", ""},
        {"{type: bool, burst: 3}", "burst.alone burst=3 [1ms..24h]"},
        {"{type: int, min_interval: 1s}", "local.not_a_trigger min_interval=1s"},
        {"{type: bool, min_interval: 1}", "duration.no_unit min_interval=1 [1ms..24h]"},
    };
    for (const auto& [keys, expected] : locals) EXPECT_EQ(findings_text({.local = keys}), expected) << keys;
    const auto kept = project(
        {.variable = "{write: 0x10, min_interval: 2s, burst: 3}", .local = "{type: bool, min_interval: 5s}"});
    EXPECT_EQ(kept.lines[0].devices[0].variables[0].admission, (model::RateLimit{2s, 3}));
    EXPECT_EQ(kept.locals[2].admission, (model::RateLimit{5s, 1}));
    EXPECT_EQ(kept.locals[0].admission, std::nullopt);
}

// A silent device is asked once each period: the pause fills the period up (docs/specification.md, section
// 13).
TEST(PlanningKeys, TheControllerAsksASilentDeviceOnceEachPeriod) {
    constexpr std::string_view kOwen = "{profile: owen-kc1}";
    const auto pause = [&](std::string_view keys) { return device(keys, kOwen).backoff.value(); };
    EXPECT_EQ(pause("{poll_period: 1s, response_timeout: 100ms}").first, 898ms);
    EXPECT_EQ(pause("{poll_period: 1s, response_timeout: 100ms}").limit, 898ms);
    EXPECT_EQ(pause("{poll_period: 100ms, response_timeout: 100ms}").limit, 10ms);
    EXPECT_EQ(pause("{poll_period: 0ms}").limit, 1ms);
    EXPECT_EQ(pause("{backoff: 2s}").first, 2s);
    EXPECT_FALSE(device("{}", "{profile: owen-kc1, backoff: 2s}").backoff);
    EXPECT_FALSE(device("{}").backoff);
}

// The device has holding register 5 to 9 and nothing else.
TEST(PlanningKeys, OffersAreTheRangesOfADevice) {
    const auto findings = [](const std::string& offers, const std::string& variables) {
        std::string all;
        const auto read =
            "{takt: 1, lines: [{name: N, port: /dev/ttyS0, devices: [{name: D, address: 1, offers: " +
            offers + ", variables: [" + variables + "]}]}]}";
        for (const auto& finding : interpret({.files = {"p"}, .root = flow(read)}).findings)
            all += finding.code + " " + finding.value + " [" + finding.allowed + "]\n";
        return all;
    };
    const std::string range = "{holding_register: [5..9]}";
    EXPECT_EQ(findings(range, "{name: A, type: float, register: 8, read: 3}"), "");
    EXPECT_EQ(findings(range, "{name: A, type: float, register: 8, read: 4}"),
              "variable.area_not_offered 8..9 []\n");
    EXPECT_EQ(findings("{holding_register: [9..5]}", "{name: A, type: int, register: 8, read: 3}"),
              "range.reversed 9..5 [0..65535]\n");
    EXPECT_EQ(findings(range, "{name: A, type: float, register: 9, read: 3}"),
              "variable.not_offered 9..10 [5..9]\n");
    EXPECT_EQ(findings("[0..9, 20]", "{name: A, type: int, register: 10, read: 4}"),
              "variable.not_offered 10 [0..9, 20]\n");
    EXPECT_EQ(findings("{coil: [0..15]}", "{name: A, type: bool, coil: 16, read: 1}"),
              "variable.not_offered 16 [0..15]\n");
    EXPECT_EQ(findings("[9..5]", "{name: A, type: int, register: 10, read: 4}"),
              "range.reversed 9..5 [0..65535]\n");
}

}  // namespace planning_keys_test
}  // namespace takt::model::test
