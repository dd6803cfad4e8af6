// Arguments of the command line to the settings of the commands.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "commands.hpp"
#include "parsed.hpp"

namespace takt::app {
namespace options_test {

using namespace std::chrono_literals;
using test::options_of;
using test::parse;
using wire::Area;

TEST(Options, DefaultsOfAClient) {
    const auto read = options_of<ReadOptions>("read tcp://h:502 holding 5");
    EXPECT_EQ(read.target, "tcp://h:502");
    EXPECT_EQ(read.unit, 1);
    EXPECT_EQ(read.timeout, 1s);
    EXPECT_EQ(read.attempts, 1);
    EXPECT_FALSE(read.adaptive || read.reconnect || read.json || read.changes || read.registers_only);
    EXPECT_EQ(read.traffic, "");
    EXPECT_EQ(read.spec.area, Area::holding_register);
    EXPECT_EQ(read.spec.start, 5);
    EXPECT_EQ(read.spec.count, 1U);
    EXPECT_EQ(read.spec.layout.type, DataType::uint16);
    EXPECT_FALSE(read.watch || read.run_for);
    EXPECT_TRUE(read.also.empty());
}

TEST(Options, OfAClient) {
    const auto read = options_of<ReadOptions>(
        "read rtu:///dev/ttyS1 input 65535 65536 --unit 255 --timeout 1.5s --attempts 255 --json --traffic "
        "-");
    EXPECT_EQ(read.spec.area, Area::input_register);
    EXPECT_EQ(read.spec.start, 65535);
    EXPECT_EQ(read.spec.count, 65536U);
    EXPECT_EQ(read.unit, 255);
    EXPECT_EQ(read.timeout, 1500ms);
    EXPECT_EQ(read.attempts, 255);
    EXPECT_TRUE(read.json);
    EXPECT_EQ(read.traffic, "-");
}

TEST(Options, TypesAndOrders) {
    const struct {
        const char* arguments;
        DataType type;
        bool high_byte_first, high_register_first;
    } cases[] = {{"--type int16", DataType::int16, true, false},
                 {"--type uint16", DataType::uint16, true, false},
                 {"--type int32 --order 4321", DataType::int32, true, true},
                 {"--type uint32 --order 1234", DataType::uint32, false, false},
                 {"--type int64 --order 3412", DataType::int64, false, true},
                 {"--type uint64 --order 2143", DataType::uint64, true, false},
                 {"--type float", DataType::float32, true, false},
                 {"--type double", DataType::float64, true, false},
                 {"--type string --length 125", DataType::string, true, false}};
    for (const auto& c : cases) {
        SCOPED_TRACE(c.arguments);
        const auto layout =
            options_of<ReadOptions>("read tcp://h holding 0 " + std::string(c.arguments)).spec.layout;
        EXPECT_EQ(layout.type, c.type);
        EXPECT_EQ(layout.order.high_byte_first, c.high_byte_first);
        EXPECT_EQ(layout.order.high_register_first, c.high_register_first);
    }
    EXPECT_EQ(
        options_of<ReadOptions>("read tcp://h holding 0 --type string --length 125").spec.layout.registers,
        125);
    EXPECT_TRUE(options_of<ReadOptions>("read tcp://h coils 0 --type int16").registers_only);
    EXPECT_TRUE(options_of<WriteOptions>("write tcp://h coils 0 1 --type uint16").registers_only);
}

TEST(Options, AnIntervalMayFollowWatch) {
    const struct {
        const char* arguments;
        Duration interval;
        std::uint32_t count;
    } cases[] = {{"holding 0 --watch", 1s, 1},     {"holding 0 --watch 200ms", 200ms, 1},
                 {"--watch holding 0 4", 1s, 4},   {"--watch 2s holding 0 4", 2s, 4},
                 {"holding --watch 0 4", 1s, 4},   {"holding 0 --watch 4", 1s, 4},
                 {"holding 0 --watch=1ms", 1ms, 1}};
    for (const auto& [arguments, interval, count] : cases) {
        SCOPED_TRACE(arguments);
        const auto read = options_of<ReadOptions>("read tcp://h " + std::string(arguments));
        EXPECT_EQ(read.watch, interval);
        EXPECT_EQ(read.spec.count, count);
        EXPECT_TRUE(read.reconnect) << "a watch survives a lost connection";
    }
    const auto read = options_of<ReadOptions>(
        "read --watch tcp://h holding 0 --for 1h --changes --also coils:7 --also input:1:65536");
    EXPECT_EQ(read.target, "tcp://h");
    EXPECT_EQ(read.run_for, Duration(1h));
    EXPECT_TRUE(read.changes);
    ASSERT_EQ(read.also.size(), 2U);
    EXPECT_EQ(read.also[0].area, Area::coil);
    EXPECT_EQ(read.also[0].start, 7);
    EXPECT_EQ(read.also[0].count, 1U);
    EXPECT_EQ(read.also[1].count, 65536U);
}

TEST(Options, ARangeOfAWatchMayHaveATypeOfItsOwn) {
    const auto read = options_of<ReadOptions>(
        "read --watch tcp://h holding 0 --also holding:4:float --also input:1:2:int32:ABCD --also holding:7");
    ASSERT_EQ(read.also.size(), 3U);
    EXPECT_EQ(read.also[0].type, DataType::float32);
    EXPECT_EQ(read.also[0].count, 1U);
    EXPECT_FALSE(read.also[0].order);
    EXPECT_EQ(read.also[1].type, DataType::int32);
    EXPECT_EQ(read.also[1].count, 2U);
    EXPECT_EQ(read.also[1].order, (ByteOrder{true, true}));
    EXPECT_FALSE(read.also[2].type);
    for (const auto* const wrong :
         {"holding:4:flaot", "coils:4:float", "holding:4:float:2:ABCD", "holding:4:ABCD",
          "holding:4:2:float:ABDC", "holding:float", "holding:4:2:", "holding:4:all"})
        EXPECT_TRUE(parse("read --watch tcp://h holding 0 --also " + std::string(wrong)).error) << wrong;
}

TEST(Options, AllTypes) {
    const auto all = options_of<ReadOptions>("read tcp://h holding 0 --type all");
    EXPECT_TRUE(all.all_types && !all.count_given);
    EXPECT_TRUE(options_of<ReadOptions>("read tcp://h holding 0 3 --type all").count_given);
    EXPECT_FALSE(options_of<ReadOptions>("read tcp://h holding 0 --type float").all_types);
    EXPECT_TRUE(parse("write tcp://h holding 0 5 --type all").error);
}

TEST(Options, OfAWriteAndARawRequest) {
    const auto write = options_of<WriteOptions>("write tcp://h holding 7 -1 0x10 '' --multiple");
    EXPECT_EQ(write.spec.area, Area::holding_register);
    EXPECT_EQ(write.spec.start, 7);
    EXPECT_EQ(write.spec.values, (std::vector<std::string>{"-1", "0x10", ""}));
    EXPECT_TRUE(write.spec.multiple);
    const auto raw = options_of<RawOptions>("raw tcp://h --unit 0 03 00:05 0001");
    EXPECT_EQ(raw.bytes, (std::vector<std::string>{"03", "00:05", "0001"}));
    EXPECT_EQ(raw.unit, 0);
}

TEST(Options, OfLatency) {
    const auto defaults = options_of<LatencyOptions>("latency a.pcap");
    EXPECT_EQ(defaults.source, "a.pcap");
    EXPECT_EQ(defaults.timeout, 1s);
    EXPECT_TRUE(defaults.ports.empty() && !defaults.limit && defaults.histogram == 0);
    EXPECT_FALSE(defaults.grouping);
    const auto given = options_of<LatencyOptions>(
        "latency - --limit 1ms --timeout 200ms --port 1502 --port 65535 --by server,unit --csv --svg "
        "plot.svg");
    EXPECT_EQ(given.source, "-");
    EXPECT_EQ(given.limit, 1ms);
    EXPECT_EQ(given.timeout, 200ms);
    EXPECT_EQ(given.ports, (std::vector<std::uint16_t>{1502, 65535}));
    EXPECT_TRUE(!given.grouping->client && given.grouping->server && given.grouping->unit &&
                !given.grouping->function);
    EXPECT_FALSE(options_of<LatencyOptions>("latency a --by none").grouping->unit);
    for (const auto* const wrong :
         {"--port 0", "--port 65536", "--port x", "--by units", "--limit 1", "--histogram 0", "--json --csv",
          "--csv --histogram 5", "--csv --svg -", "--json --svg -"})
        EXPECT_TRUE(parse("latency a " + std::string(wrong)).error) << wrong;
}

TEST(Options, OfLatencyOfATarget) {
    const auto defaults = options_of<LatencyOptions>("latency tcp://h").load;
    EXPECT_TRUE(!defaults.area && !defaults.unit && !defaults.rate && !defaults.run_for &&
                !defaults.requests);
    const auto load = options_of<LatencyOptions>(
                          "latency tcp://h:1502 input 100 10 --unit 7 --connections 4 --in-flight 8 --rate "
                          "1000/s --for 1h --requests 500 --same-content --realtime --cpu 1 --spin 50us")
                          .load;
    EXPECT_EQ(load.area, Area::input_register);
    EXPECT_EQ(load.start, 100U);
    EXPECT_EQ(load.quantity, 10U);
    EXPECT_EQ(load.unit, 7U);
    EXPECT_EQ(load.connections, 4U);
    EXPECT_EQ(load.in_flight, 8U);
    EXPECT_EQ(load.rate, (client::Rate{1000, 1s}));
    EXPECT_EQ(load.run_for, 1h);
    EXPECT_EQ(load.requests, 500U);
    EXPECT_TRUE(load.same_content);
    EXPECT_EQ(load.realtime.spin, 50us);
    EXPECT_EQ(options_of<LatencyOptions>("latency tcp://h --rate 30/min").load.rate,
              (client::Rate{30, 1min}));
    for (const auto* const wrong :
         {"--rate 0/s", "--rate 1000", "--rate 1000001/s", "--rate -1/s", "--rate 10/h", "--connections 0",
          "--connections 257", "--in-flight 17", "--for 0s", "--requests 0", "--port 502", "--by none",
          "registers", "holding 65536", "holding 0 0", "holding 0 2001", "--spin 1s", "--unit 256"})
        EXPECT_TRUE(parse("latency tcp://h " + std::string(wrong)).error) << wrong;
    for (const auto* const wrong :
         {"holding", "--unit 1", "--connections 2", "--in-flight 2", "--rate 1/s", "--for 1s", "--requests 9",
          "--same-content", "--realtime", "--cpu 0", "--spin 1us"})
        EXPECT_TRUE(parse("latency a.pcap " + std::string(wrong)).error) << wrong;
    EXPECT_TRUE(parse("latency udp://h").error);
}

TEST(Options, OfListen) {
    const auto defaults = options_of<ListenOptions>("listen /dev/ttyUSB0");
    EXPECT_EQ(defaults.port, "/dev/ttyUSB0");
    EXPECT_EQ(defaults.timeout, 1s);
    EXPECT_TRUE(!defaults.run_for && !defaults.quiet && !defaults.json && !defaults.force);
    const auto given = options_of<ListenOptions>(
        "listen ascii:///dev/x?baud=9600 --project a --write b --force --for 10s --timeout 200ms --quiet "
        "--json");
    EXPECT_EQ(given.port, "ascii:///dev/x?baud=9600");
    EXPECT_EQ(given.project, "a");
    EXPECT_EQ(given.write, "b");
    EXPECT_EQ(given.run_for, 10s);
    EXPECT_EQ(given.timeout, 200ms);
    EXPECT_TRUE(given.force && given.quiet && given.json);
    for (const auto* const wrong :
         {"", "tcp://h", "rtu:///dev/x?baud=x", "/dev/x --for 0s", "/dev/x --timeout 1"})
        EXPECT_TRUE(parse("listen " + std::string(wrong)).error) << wrong;
}

TEST(Options, OfAScanAndAProbe) {
    const auto scan = options_of<ScanOptions>(
        "scan rtu:///dev/ttyS1 tcp://10.0.0.1-9 --units 1-10 --bauds 9600 --parities even --stop-bits 1,2 "
        "--timeout 50ms --first --thorough --no-identify --project p.yaml --force");
    EXPECT_EQ(scan.targets.size(), 2U);
    EXPECT_EQ(scan.units, "1-10");
    EXPECT_EQ(scan.bauds, "9600");
    EXPECT_EQ(scan.parities, "even");
    EXPECT_EQ(scan.stop_bits, "1,2");
    EXPECT_EQ(scan.timeout, 50ms);
    EXPECT_TRUE(scan.first && scan.thorough && scan.force && !scan.identify && !scan.json);
    EXPECT_EQ(scan.project, "p.yaml");
    const auto plain = options_of<ScanOptions>("scan tcp://h");
    EXPECT_EQ(plain.units, "");
    EXPECT_TRUE(plain.identify && !plain.timeout && !plain.probe);
    EXPECT_TRUE(options_of<ScanOptions>("scan tcp://h --probe --project p.yaml").probe);
    EXPECT_TRUE(parse("scan tcp://h --probe").error) << "the ranges go into a project";

    const auto probe = options_of<ProbeOptions>(
        "probe tcp://h --area holding,coils --from 100 --to 200 --step 8 --max-requests 1000000 --yaml");
    EXPECT_EQ(probe.areas, (std::vector<Area>{Area::holding_register, Area::coil}));
    EXPECT_EQ(probe.first, 100);
    EXPECT_EQ(probe.last, 200);
    EXPECT_EQ(probe.step, 8);
    EXPECT_EQ(probe.max_requests, 1'000'000U);
    EXPECT_TRUE(probe.yaml);
    const auto whole = options_of<ProbeOptions>("probe tcp://h");
    EXPECT_TRUE(whole.areas.empty() && !whole.step);
    EXPECT_EQ(whole.last, 65535);
    EXPECT_EQ(whole.attempts, 2) << "one lost frame is no silence";
    EXPECT_TRUE(whole.adaptive && whole.reconnect);
}

TEST(Options, TheLineAndTheCommandsOfAServing) {
    const auto serve = options_of<ServeOptions>("serve plant.yaml --line A --stdin --control c.sock");
    EXPECT_EQ(serve.line, "A");
    EXPECT_TRUE(serve.commands_from_stdin);
    EXPECT_TRUE(parse("serve --line A --listen 127.0.0.1:1502").error) << "a blank device has no lines";
}

TEST(Options, OfARun) {
    const auto run = options_of<RunOptions>(
        "run plant.yaml --for 500us --json --quiet --device Boiler --traffic t.log --stdin --control c.sock "
        "--state s.state");
    EXPECT_TRUE(run.quiet);
    EXPECT_EQ(run.device, "Boiler");
    EXPECT_EQ(run.file, "plant.yaml");
    EXPECT_EQ(run.run_for, 500us);
    EXPECT_TRUE(run.json && run.commands_from_stdin && run.learn);
    EXPECT_EQ(run.traffic, "t.log");
    EXPECT_EQ(run.control_path, "c.sock");
    EXPECT_EQ(run.state, "s.state");
    const auto table = options_of<RunOptions>("run --table p.takt --port /dev/ttyS1");
    EXPECT_EQ(table.file, "");
    EXPECT_EQ(table.table, "p.takt");
    EXPECT_EQ(table.target, "/dev/ttyS1");
    EXPECT_EQ(options_of<DemoOptions>("demo --for 2min").run_for, Duration(2min));
    const auto ctl = options_of<CtlOptions>("ctl c.sock set Level -5");
    EXPECT_EQ(ctl.path, "c.sock");
    EXPECT_FALSE(ctl.json);
    EXPECT_TRUE(options_of<CtlOptions>("ctl c.sock status --json").json);
    EXPECT_EQ(ctl.words, (std::vector<std::string>{"set", "Level", "-5"}));
}

TEST(Options, OfAProjectAndATable) {
    const auto check = options_of<CheckOptions>("check p.yaml --prove --no-notes");
    EXPECT_TRUE(check.file == "p.yaml" && check.prove && check.no_notes && !check.json && !check.firmware);
    EXPECT_TRUE(options_of<CheckOptions>("check b.yaml --firmware").firmware);
    const auto plan = options_of<PlanOptions>("plan p.yaml --compare --svg - --fix");
    EXPECT_TRUE(plan.compare && plan.fix && plan.svg == "-" && !plan.prove);
    const auto build = options_of<TableBuildOptions>("table build p.yaml -o p.takt --profile owen-kc1");
    EXPECT_EQ(build.output, "p.takt");
    EXPECT_EQ(build.profile, model::Profile::owen_kc1);
    EXPECT_FALSE(options_of<TableBuildOptions>("table build p.yaml --output p.takt --no-names").profile);
    EXPECT_TRUE(options_of<TableShowOptions>("table show p.takt --json").json);
}

TEST(Options, OfAConversion) {
    const auto plain = options_of<ConvertOptions>("convert t.csv");
    EXPECT_TRUE(plain.reading.addresses == file::Addresses::zero_based && !plain.addresses_given);
    EXPECT_EQ(plain.writing.headings, file::Headings::keys);
    EXPECT_EQ(plain.line, "line");
    EXPECT_EQ(plain.target, "rtu:///dev/ttyUSB0");
    EXPECT_TRUE(!plain.unit && !plain.encoding && plain.separator == 0 && plain.output.empty());
    const auto all = options_of<ConvertOptions>(
        "convert in -o out --force --from csv --to yaml --line bus --device Pump --unit 0 --target tcp://h "
        "--addresses reference --headings ru --separator tab --encoding utf-8-bom --input-separator ; "
        "--input-encoding cp1251");
    EXPECT_TRUE(all.force && all.byte_order_mark);
    EXPECT_EQ(all.from, FileKind::csv);
    EXPECT_EQ(all.to, FileKind::yaml);
    EXPECT_EQ(all.line + ' ' + all.device + ' ' + all.target, "bus Pump tcp://h");
    EXPECT_EQ(all.unit, 0);
    EXPECT_EQ(all.reading.addresses, file::Addresses::reference);
    EXPECT_EQ(all.writing.headings, file::Headings::russian);
    EXPECT_EQ(all.separator, '\t');
    EXPECT_EQ(all.encoding, file::Encoding::utf8);
    EXPECT_EQ(all.reading.separator, ';');
    EXPECT_EQ(all.reading.encoding, file::Encoding::cp1251);
}

TEST(Options, OfABlankDevice) {
    const auto serve = options_of<ServeOptions>(
        "serve --listen 127.0.0.1:0 --port /dev/ttyS1 --unit 0 --fill ramp --strict");
    EXPECT_EQ(serve.listen, "127.0.0.1:0");
    EXPECT_EQ(serve.port, "/dev/ttyS1");
    EXPECT_EQ(serve.unit, UnitId{0});
    EXPECT_EQ(serve.fill, sim::Fill::ramp);
    EXPECT_TRUE(serve.strict);
}

TEST(Options, OfServers) {
    const auto serve = options_of<ServeOptions>(
        "serve p.yaml --max-connections 20000 --max-per-peer 1 --byte-timeout 40ms --frame-timeout 1ms "
        "--idle-timeout 1h "
        "--write-timeout 2s --access a.yaml --audit a.log --fault delay=50ms..2s:10% --fault silence "
        "--control c");
    EXPECT_EQ(serve.file, "p.yaml");
    EXPECT_EQ(serve.limits.max_connections, 20'000U);
    EXPECT_EQ(serve.limits.max_per_peer, 1U);
    EXPECT_EQ(serve.limits.byte_timeout, 40ms);
    EXPECT_EQ(serve.limits.frame_timeout, 1ms);
    EXPECT_EQ(serve.limits.idle_timeout, Duration(1h));
    EXPECT_EQ(serve.limits.write_timeout, 2s);
    EXPECT_EQ(serve.access + ' ' + serve.audit + ' ' + serve.control_path, "a.yaml a.log c");
    ASSERT_EQ(serve.faults.size(), 2U);
    EXPECT_EQ(serve.faults[0].most, 2s);
    EXPECT_EQ(serve.faults[0].per_million, 100'000U);
    const auto plain = options_of<ServeOptions>("serve p.yaml");
    EXPECT_TRUE(!plain.limits.max_connections && !plain.limits.idle_timeout && plain.faults.empty());
}

TEST(Options, WhatIsRejectedAndWhy) {
    const struct {
        const char* line;
        const char* code;
        const char* option;
    } cases[] = {
        {"read tcp://h holding", "app.option.required", "START"},
        {"read tcp://h holding 65536", "app.option.range", "START"},
        {"read tcp://h holding -1", "app.option.range", "START"},
        {"read tcp://h holding x", "app.option.number", "START"},
        {"read tcp://h holding 010", "app.option.leading_zero", "START"},
        {"read tcp://h holding 0 65537", "app.option.range", "COUNT"},
        {"read tcp://h registers 0", "app.option.word", "AREA"},
        {"read tcp://h holding 0 --unit 256", "app.option.range", "--unit"},
        {"read tcp://h holding 0 --unit", "app.option.no_value", "--unit"},
        {"read tcp://h holding 0 --attempts 0", "app.option.range", "--attempts"},
        {"read tcp://h holding 0 --timeout 0ms", "app.option.range", "--timeout"},
        {"read tcp://h holding 0 --timeout 5", "app.option.duration", "--timeout"},
        {"read tcp://h holding 0 --timeout 1.5.2s", "app.option.duration", "--timeout"},
        {"read tcp://h holding 0 --timeout -1s", "app.option.range", "--timeout"},
        {"read tcp://h holding 0 --timeout 1e9h", "app.option.duration", "--timeout"},
        {"read tcp://h holding 0 --timeout 99999999999h", "app.option.range", "--timeout"},
        {"run p.yaml --for 1,000ms", "app.option.duration.comma", "--for"},
        {"run p.yaml --for -1ms", "app.option.range", "--for"},
        {"run p.yaml --for -x", "app.option.duration", "--for"},
        {"read tcp://h holding 0 --timeout 9000h", "app.option.range", "--timeout"},
        {"read tcp://h holding 0 --type real", "app.option.word", "--type"},
        {"read tcp://h holding 0 --order 4312", "app.option.word", "--order"},
        {"read tcp://h holding 0 --length 126", "app.option.range", "--length"},
        {"read tcp://h holding 0 --watch 500us", "app.option.range", "--watch"},
        {"read tcp://h holding 0 --watch --also coils", "app.option.form.watched", "--also"},
        {"read tcp://h holding 0 --watch --also coils:0:0", "app.option.form.watched", "--also"},
        {"read tcp://h holding 0 --watch --also coils:0x1", "app.option.form.watched", "--also"},
        {"read tcp://h holding 0 --changes", "app.option.requires", "--changes"},
        {"read host:502 holding 0", "app.option.target", "TARGET"},
        {"read tcp://h:99999 holding 0", "app.option.target", "TARGET"},
        {"probe tcp://", "app.option.target", "TARGET"},
        {"raw tcp://h:x 03", "app.option.target", "TARGET"},
        {"scan tcp://h tcp://h:99999", "app.option.target", "TARGET"},
        {"scan tcp://10.0.0.5-1", "app.option.target", "TARGET"},
        {"convert t.csv --target h", "app.option.target", "--target"},
        {"run", "app.option.nothing_to_run", nullptr},
        {"run p.yaml --table p.takt", "app.option.excludes", "FILE"},
        {"run p.yaml --port /dev/ttyS1", "app.option.requires", "--port"},
        {"scan", "app.option.required", "TARGET"},
        {"probe tcp://h --area holding,", "app.option.word.nearest", "--area"},
        {"probe tcp://h --step 0", "app.option.range", "--step"},
        {"probe tcp://h --max-requests 1000001", "app.option.range", "--max-requests"},
        {"table build p.yaml", "app.option.required", "--output"},
        {"table build p.yaml -o t --profile generic", "app.option.word", "--profile"},
        {"convert t.csv --encoding utf-16", "app.option.word.nearest", "--encoding"},
        {"convert t.csv --unit 256", "app.option.range", "--unit"},
        {"convert t.csv --separator space", "app.option.word", "--separator"},
        {"serve --fault noise", "app.option.form.fault", "--fault"},
        {"serve --max-connections 20001", "app.option.range", "--max-connections"},
        {"serve --idle-timeout 0s", "app.option.range", "--idle-timeout"},
        {"serve p.yaml --unit 2", "app.option.excludes", "FILE"},
        {"check p.yaml q.yaml", "app.option.extra", nullptr},
    };
    for (const auto& [line, code, option] : cases) {
        SCOPED_TRACE(line);
        const auto parsed = parse(line);
        EXPECT_FALSE(parsed.options.has_value());
        ASSERT_TRUE(parsed.error);
        EXPECT_EQ(parsed.error->code, code);
        if (!option) continue;
        ASSERT_FALSE(parsed.error->arguments.empty());
        EXPECT_EQ(parsed.error->arguments[0], (std::pair<std::string, std::string>{"option", option}));
    }
}

TEST(Options, ArgumentsThatNoCommandTakesAreNamed) {
    EXPECT_EQ(parse("check p.yaml q.yaml r.yaml").error,
              (OptionError{"app.option.extra", {{"value", "q.yaml r.yaml"}}}));
    EXPECT_EQ(parse("check p.yaml -1").error, (OptionError{"app.option.extra", {{"value", "-1"}}}));
    const auto unknown = [](const std::string& value, const std::string& nearest) {
        return OptionError{"app.option.unknown", {{"value", value}, {"nearest", nearest}}};
    };
    EXPECT_EQ(parse("run p.yaml --forr 3s").error, unknown("--forr", "--for"));
    EXPECT_EQ(parse("run p.yaml --forr=3s").error, unknown("--forr", "--for"));
    EXPECT_EQ(parse("table build p.yaml --outptu t -o t").error, unknown("--outptu", "--output"));
    // its value is not reported in the place of an argument
    for (const std::string line :
         {"read --unt 5 tcp://h holding 0", "--unt 5 read tcp://h holding 0", "read --unt",
          "read tcp://h --unt=5 holding 0", "read tcp://h wrong 0 --unt 5"})
        EXPECT_EQ(parse(line).error, unknown("--unt", "--unit")) << line;
    EXPECT_EQ(parse("run p.yaml -x").error, (OptionError{"app.option.unknown.unlike", {{"value", "-x"}}}));
    EXPECT_EQ(parse("run p.yaml --variables").error,
              (OptionError{"app.option.unknown.key", {{"value", "--variables"}, {"key", "variables"}}}));
    EXPECT_EQ(parse("plan p.yaml --strategy clasic").error,
              (OptionError{"app.option.unknown.key", {{"value", "--strategy"}, {"key", "strategy"}}}));
    EXPECT_EQ(parse("plan p.yaml --xyzzy").error,
              (OptionError{"app.option.unknown.unlike", {{"value", "--xyzzy"}}}));
}

TEST(Options, TheNearestWordIsNamed) {
    const auto nearest = [](const std::string& line) {
        const auto error = parse(line).error;
        if (!error || error->code != "app.option.word.nearest") return std::string();
        return error->arguments.back().second;
    };
    EXPECT_EQ(nearest("read tcp://h holding 0 --type float32"), "float");
    EXPECT_EQ(nearest("read tcp://h holding 0 --type u16"), "uint16");
    EXPECT_EQ(nearest("write tcp://h holding 0 1 --type flaot"), "float");
    EXPECT_EQ(nearest("read tcp://h registers 0"), "") << "no word is near";
    EXPECT_EQ(nearest("read tcp://h holdng 0"), "holding");
    EXPECT_EQ(nearest("read tcp://h coil 0"), "coils");
    EXPECT_EQ(nearest("write tcp://h coli 0 1"), "coils");
    EXPECT_EQ(nearest("read tcp://h 1 0"), "");
    EXPECT_EQ(nearest("table build p.yaml -o t --profile owen"), "owen-kc1");
}

TEST(Options, AnOptionOfOneValueIsGivenOnce) {
    const auto repeated = [](const std::string& option, const std::string& count, const std::string& values) {
        return OptionError{"app.option.repeated",
                           {{"option", option}, {"count", count}, {"values", values}, {"greatest", "1"}}};
    };
    EXPECT_EQ(parse("serve --listen 127.0.0.1:1 --listen 127.0.0.1:2").error,
              repeated("--listen", "2", "127.0.0.1:1, 127.0.0.1:2"));
    EXPECT_EQ(parse("run p.yaml --capture a --capture b --capture c").error,
              repeated("--capture", "3", "a, b, c"));
    EXPECT_EQ(parse("table build p.yaml -o t --output u").error, repeated("--output", "2", "t, u"));
    EXPECT_EQ(parse("read tcp://h holding 0 --timeout 1s --timeout 2s").error,
              repeated("--timeout", "2", "1s, 2s"));
    EXPECT_FALSE(parse("check p.yaml --json --json").error) << "that has one meaning";
    std::string many = "scan";
    for (int i = 0; i < 65; ++i) many += " tcp://h";
    const auto too_many = parse(many).error;
    ASSERT_TRUE(too_many);
    EXPECT_EQ(too_many->code, "app.option.too_many");
    EXPECT_EQ(too_many->arguments[1].second, "65");
    EXPECT_EQ(too_many->arguments[3].second, "64");
}

TEST(Options, HelpIsGivenInsteadOfAnError) {
    const auto help = parse("read --help");
    EXPECT_FALSE(help.error);
    EXPECT_NE(help.text.find("--watch"), std::string::npos);
    EXPECT_EQ(help.text.find("help."), std::string::npos) << "each code has its message";
    const auto nothing = parse("table");
    EXPECT_TRUE(nothing.error);
    EXPECT_NE(nothing.text.find("build"), std::string::npos) << "the commands to choose from";
}

}  // namespace options_test
}  // namespace takt::app
