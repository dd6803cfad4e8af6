// `source`, `writes_to`, `max_age` of a server's variables, and `instruments:`.
#include <gtest/gtest.h>

#include <string>

#include "flow.hpp"
#include "takt/model/findings.hpp"

namespace takt::model::test {
namespace source_test {

using namespace std::chrono_literals;

constexpr const char* kInstruments =
    "[{name: scale, port: /dev/ttyS8, every: 200ms, timeout: 100ms, exchanges: [{request: \"*00?\\r\", "
    "answer: "
    "{until: \"\\r\", pattern: \"{weight} kg\"}}, {request: \"\\x05\", answer: {length: 6, begins: "
    "\"\\x02\", checksum: "
    "xor, fields: [{name: flow, offset: 1, type: float}]}}], "
    "commands: [{name: tare, request: \"*00T{value}\\r\", decimals: 2, digits: 4, least: -1, greatest: 60, "
    "unit: "
    "kg, answer: {until: \"\\r\", pattern: OK}, refused: {until: \"\\r\", pattern: \"ERR{*}\"}, read_back: "
    "{request: \"*00T?\\r\", answer: {until: \"\\r\", pattern: \"T{value} kg\"}}}, {name: label, request: "
    "\"L{value:text}\\r\", answer: {until: \"\\r\", pattern: OK}, attempts: 2, pause: 20ms, expires: 3s, "
    "restore: "
    "false}]}, "
    "{name: meter, transport: tcp, host: h, tcp_port: 9000, exchanges: [{answer: {until: \"\\n\", pattern: "
    "\"{v}\"}}]}]";

/// A project with one variable of a server that has these keys beside its name and location.
Checked read(const std::string& keys, const std::string& type = "float") {
    const std::string project =
        "{locals: [{name: L, type: float}, {name: T, type: string}], instruments: " +
        std::string(kInstruments) +
        ", servers: [{name: S, listen: x, units: [{address: 1, banks: [{area: holding_register, items: "
        "[0..9]}], variables: [{name: A, area: holding_register, register: 2, type: " +
        type + ", " + keys + "}]}]}]}";
    return interpret(document({.project = project, .variable = "{name: P, read: 3, write: 6}"}));
}

std::string findings_text(const Checked& checked) {
    std::string all;
    for (const auto& finding : checked.findings) {
        if (!all.empty()) all += "; ";
        if (finding.severity == Severity::warning) all += '?';
        all += finding.code + " " + finding.path.substr(finding.path.rfind('.') + 1);
    }
    return all;
}

const Binding& only(const Checked& checked) {
    EXPECT_EQ(findings_text(checked), "");
    return checked.project.servers.at(0).units.at(0).bindings.at(0);
}

TEST(Sources, Generators) {
    const auto sine = read("source: {sine: {amplitude: 10, offset: 20, period: 1min}}");
    const auto& generator = std::get<Generator>(*only(sine).source);
    EXPECT_EQ(generator.motion, Generator::Motion::sine);
    EXPECT_EQ(generator.from, 10);
    EXPECT_EQ(generator.to, 30);
    EXPECT_EQ(generator.period, 1min);
    EXPECT_FALSE(only(sine).max_age);
    EXPECT_FALSE(only(sine).sink);
    const auto ramp = read("source: {ramp: {from: 9, to: 1, period: 2s}}");
    EXPECT_EQ(std::get<Generator>(*only(ramp).source).to, 1);
    const auto walk = read("source: {random_walk: {to: 5, step: 0.5, every: 100ms, seed: 7}}");
    EXPECT_EQ(std::get<Generator>(*only(walk).source).seed, 7u);
    const auto counter = read("source: {counter: {from: 1, to: 4, every: 1s}}");
    EXPECT_EQ(std::get<Generator>(*only(counter).source).motion, Generator::Motion::counter);
    const auto constant = read("source: {constant: 2.5}");
    EXPECT_EQ(std::get<Constant>(*only(constant).source).number, 2.5);
}

TEST(Sources, OutsideTheProgram) {
    const auto file = read("source: {file: {path: /sys/x, every: 50ms, pattern: \"t={value}\"}}");
    EXPECT_EQ(std::get<FileSource>(*only(file).source).path, "/sys/x");
    EXPECT_EQ(only(file).max_age, 1s) << "three looks, at least a second";
    const auto command = read("source: {command: {run: [date, \"+%s\"], every: 5s, timeout: 2s}}");
    EXPECT_EQ(std::get<CommandSource>(*only(command).source).command.run,
              (std::vector<std::string>{"date", "+%s"}));
    EXPECT_EQ(only(command).max_age, 17s);
    const auto replay =
        read("source: {replay: {file: day.csv, column: t, loop: false}}, writes_to: {local: L}");
    EXPECT_FALSE(std::get<Replay>(*only(replay).source).loop);
    EXPECT_EQ(std::get<LocalSource>(*only(replay).sink).name, "L");
}

TEST(Sources, InsideTheProject) {
    const auto polled = read("source: {variable: P}, writes_to: {variable: P}, answer: at_once, max_age: 7s");
    EXPECT_EQ(std::get<VariableSource>(*only(polled).source).name, "P");
    EXPECT_EQ(std::get<VariableSource>(*only(polled).sink).name, "P");
    EXPECT_TRUE(only(polled).answer_at_once);
    EXPECT_EQ(only(polled).max_age, 7s);
    EXPECT_EQ(only(read("source: {variable: P}")).max_age, 3s) << "three periods, at least a second";
    const auto local = read("source: {local: L}");
    EXPECT_EQ(std::get<LocalSource>(*only(local).sink).name, "L") << "a local is written where it is read";
    EXPECT_FALSE(only(local).max_age);
    const auto measured = read("source: {instrument: scale.flow}");
    EXPECT_EQ(std::get<InstrumentSource>(*only(measured).source).measurement, "flow");
    EXPECT_EQ(only(measured).max_age, 1100ms);
}

TEST(Sources, Instruments) {
    const auto checked = read("source: {instrument: meter.v}");
    EXPECT_EQ(findings_text(checked), "");
    const auto& scale = checked.project.instruments.at(0);
    EXPECT_TRUE(scale.is_asked());
    EXPECT_EQ(scale.exchanges.at(0).request, "*00?\r");
    EXPECT_EQ(scale.exchanges.at(0).answer.until, "\r");
    const auto& binary = scale.exchanges.at(1).answer;
    EXPECT_EQ(binary.begins, "\x02");
    EXPECT_EQ(binary.checksum, Checksum::exclusive_or);
    EXPECT_EQ(binary.fields.at(0).bytes, 4);
    EXPECT_FALSE(checked.project.instruments.at(1).is_asked());
}

TEST(Sources, CommandsOfInstruments) {
    const auto checked = read("source: {instrument: scale.weight}, writes_to: {instrument: scale.tare}");
    EXPECT_EQ(std::get<InstrumentSink>(*only(checked).sink), (InstrumentSink{0, 0}));
    const auto& scale = checked.project.instruments.at(0);
    const auto& tare = scale.commands.at(0);
    EXPECT_EQ(tare.kind(), TextTemplate::Kind::number);
    EXPECT_EQ(tare.format, (NumberFormat{.decimals = 2, .digits = 4, .least = -1.0, .greatest = 60.0}));
    EXPECT_EQ(tare.unit, "kg");
    EXPECT_EQ(tare.confirmation.timeout, 100ms) << "that of the instrument";
    EXPECT_EQ(tare.confirmation.attempts, 1);
    EXPECT_EQ(tare.read_back->request, "*00T?\r");
    EXPECT_EQ(tare.expires, 1s);
    EXPECT_TRUE(tare.restore);
    const auto& label = scale.commands.at(1);
    EXPECT_EQ(label.confirmation.attempts, 2);
    EXPECT_EQ(label.confirmation.pause, 20ms);
    EXPECT_EQ(label.expires, 3s);
    EXPECT_FALSE(label.restore);
    EXPECT_EQ(std::get<InstrumentSink>(
                  *only(read("length: 4, writes_to: {instrument: scale.label}", "string")).sink),
              (InstrumentSink{0, 1}));
    const auto state = read("source: {instrument: meter.state}", "int");
    EXPECT_EQ(std::get<InstrumentSource>(*only(state).source), (InstrumentSource{1, ""}));
    EXPECT_FALSE(only(state).max_age);
}

TEST(Sources, WithoutAnyCommandNoneIsListed) {
    const auto checked = interpret(document(
        {.project =
             "{servers: [{name: S, listen: x, units: [{address: 1, banks: [{area: holding_register, items: "
             "[0]}], variables: [{name: A, area: holding_register, register: 0, type: int, writes_to: "
             "{instrument: scale.tare}}]}]}]}"}));
    EXPECT_EQ(findings_text(checked), "name.none instrument");
}

TEST(Sources, MistakesAreReported) {
    struct Row {
        std::string keys;
        const char* expected;
        const char* type = "float";
    };
    const Row rows[] = {
        {"source: {}", "group.one_of source"},
        {"source: {constant: 1, variable: P}", "group.one_of source"},
        {"source: {sinus: 1}", "key.unknown sinus"},
        {"source: {variable: Q}", "source.unknown variable"},
        {"source: {local: Q}", "source.unknown local"},
        {"source: {instrument: scale}", "source.unknown instrument"},
        {"source: {instrument: scale.v}", "source.unknown instrument"},
        {"source: {local: T}", "source.type local"},
        {"length: 1, source: {instrument: scale.state}", "source.type instrument", "string"},
        {"writes_to: {instrument: scale.tara}", "instrument.command_unknown instrument"},
        {"writes_to: {instrument: meter.tare}", "instrument.command_unknown instrument"},
        {"writes_to: {instrument: tare}", "instrument.command_unknown instrument"},
        {"writes_to: {instrument: scale.label}", "source.type instrument"},
        {"length: 1, writes_to: {instrument: scale.tare}", "source.type instrument", "string"},
        {"length: 1, source: {variable: P}", "source.type variable", "string"},
        {"length: 1, source: {ramp: {to: 1, period: 1s}}", "source.type ramp", "string"},
        {"source: {constant: x}", "number.malformed constant"},
        {"source: {counter: {from: 4, to: 4}}", "field.out_of_range to"},
        {"source: {random_walk: {to: 4, step: 0}}", "field.out_of_range step"},
        {"source: {sine: {amplitude: 1}}", "field.missing period"},
        {"source: {file: {path: x, pattern: \"{v}\"}}", "template.without pattern"},
        {"source: {file: {path: x, pattern: \"{v\"}}", "template.malformed pattern"},
        {"source: {file: {path: x, every: 1ms}}", "field.out_of_range every"},
        {"source: {command: {run: []}}", "command.empty run"},
        {"source: {command: {run: [\"\"]}}", "command.empty run"},
        {"source: {constant: 1}, max_age: 1s", "?field.without_effect max_age"},
        {"answer: at_once", "?field.without_effect answer"},
        {"writes_to: {local: L}, max_age: 1s", "?field.without_effect max_age"},
    };
    for (const auto& [keys, expected, type] : rows)
        EXPECT_EQ(findings_text(read(keys, type)), expected) << keys;
}

TEST(Sources, OnlyWhatCanBeWrittenTakesWrites) {
    const auto checked = interpret(document(
        {.project =
             "{servers: [{name: S, listen: x, units: [{address: 1, banks: [{area: holding_register, items: "
             "[0]}], variables: [{name: A, area: holding_register, register: 0, type: int, writes_to: "
             "{variable: P}}]}]}]}",
         .variable = "{name: P, read: 3, write: none}"}));
    EXPECT_EQ(findings_text(checked), "source.not_writable variable");
}

TEST(Instruments, MistakesAreReported) {
    struct Row {
        const char* keys;
        const char* expected;
    };
    const Row rows[] = {
        {"exchanges: [{request: a, answer: {until: b, pattern: \"{v}\"}}]", "line.port_missing port"},
        {"port: p, exchanges: []", "field.empty exchanges"},
        {"transport: tcp, host: h, exchanges: [{answer: {until: b, pattern: \"{v}\"}}]",
         "line.port_missing tcp_port"},
        {"host: h, exchanges: [{answer: {until: b, pattern: \"{v}\"}}]", "line.port_missing tcp_port"},
        {"transport: tls, host: h, exchanges: [{answer: {until: b, pattern: \"{v}\"}}]",
         "line.tls transport"},
        {"port: p, host: h, exchanges: [{answer: {until: b, pattern: \"{v}\"}}]",
         "?field.without_effect host"},
        {"port: p, every: 1s, exchanges: [{answer: {until: b, pattern: \"{v}\"}}]",
         "?field.without_effect every"},
        {"port: p, exchanges: [{request: a, answer: {until: b, pattern: \"{v}\"}}, {answer: {until: b, "
         "pattern: "
         "\"{w}\"}}]",
         "exchange.mixed request"},
        {"port: p, exchanges: [{answer: {until: b, pattern: \"{v}\"}}, {answer: {until: b, pattern: "
         "\"x{v}\"}}]",
         "number.twice pattern"},
        {"port: p, exchanges: [{answer: {pattern: \"{v}\"}}]", "field.missing until"},
        {"port: p, exchanges: [{answer: {length: 2, until: b}}]", "answer.form until"},
        {"port: p, exchanges: [{answer: {until: b, pattern: \"{v}\", checksum: sum}}]",
         "answer.form checksum"},
        {"port: p, exchanges: [{answer: {length: 3, checksum: sum, fields: [{name: v, offset: 1, type: "
         "int16}]}}]",
         "measurement.beyond offset"},
        {"port: p, exchanges: [{answer: {length: 2, checksum: crc16, begins: a}}]",
         "measurement.beyond length"},
        {"port: p, exchanges: [{request: \"\", answer: {until: b, pattern: \"{v}\"}}]",
         "template.malformed request"},
    };
    for (const auto& [keys, expected] : rows) {
        const std::string project = "{instruments: [{name: I, " + std::string(keys) + "}]}";
        EXPECT_EQ(findings_text(interpret(document({.project = project}))), expected) << keys;
    }
}

TEST(Instruments, MistakesOfCommandsAreReported) {
    struct Row {
        std::string keys;
        const char* expected;
    };
    const std::string ok = "answer: {until: b, pattern: OK}";
    const auto command = [&ok](const std::string& keys, const std::string& request = "T{value};") {
        return "commands: [{name: c, request: \"" + request + "\", " + (keys.empty() ? ok : keys) + "}]";
    };
    const Row rows[] = {
        {command(""), ""},
        {command(ok + ", attempts: 0"), "field.out_of_range attempts"},
        {command(ok + ", timeout: 2min"), "field.out_of_range timeout"},
        {command(ok + ", expires: never"), "duration.malformed expires"},
        {command(ok + ", expires: 0"), "field.out_of_range expires"},
        {command(ok + ", expires: 900ms"), "?instrument.expires expires"},
        {command(ok + ", attempts: 3, expires: 1500ms"), "?instrument.expires expires"},
        {command(ok + ", least: 5, greatest: 4"), "instrument.range greatest"},
        {command(ok + ", least: x"), "number.malformed least"},
        {command(ok + ", decimals: 10"), "field.out_of_range decimals"},
        {command("", "T;"), "instrument.placeholder request"},
        {command("", "T{weight};"), "instrument.placeholder request"},
        {command("", "T{value}{*};"), "template.malformed request"},
        {command("", "T{value};{*}"), "instrument.placeholder request"},
        {command("", "T{value;"), "template.malformed request"},
        {command("unit: kg"), "instrument.unconfirmed answer"},
        {command("refused: {until: b, pattern: E}"), "field.missing answer"},
        {command("answer: {until: b, pattern: \"{value:text}\"}"), "instrument.value_kind answer"},
        {command("answer: {until: b, pattern: \"{value}\"}", "{value:text};"),
         "instrument.value_kind answer"},
        {command("read_back: {request: r, answer: {until: b, pattern: \"{v}\"}}"), "template.without answer"},
        {command("read_back: {request: r}"), "field.missing answer"},
        {command(ok + ", decimals: 1", "{value:hex};"), "?field.without_effect decimals"},
        {command(ok + ", least: 1", "{value:text};"), "?field.without_effect least"},
        {"commands: [{name: c, request: \"{value}\", " + ok + "}, {name: c, request: \"{value}\", " + ok +
             "}]",
         "number.twice name"},
        {"start: [{request: \"\\q\"}]", "template.malformed request"},
        {"start: [{answer: {until: b, pattern: OK}}]", "field.missing request"},
        {"start: [{request: a, refused: {until: b, pattern: E}}]", "field.missing answer"},
        {"start: [a]", "field.not_a_mapping start[0]"},
        {"start: [{request: a, attempts: 256}]", "field.out_of_range attempts"},
        {"start: [{request: a}], reset: {until: b, pattern: \"{*}\"}", "instrument.any_data reset"},
        {"start: [{request: a}], reset: {length: 3}", "instrument.any_data reset"},
        {"start: [{request: a}], silent_after: 256", "field.out_of_range silent_after"},
        {"silent_after: 4", "?field.without_effect silent_after"},
        {"start: [{request: a}], reset: READY", "field.not_a_group reset"},
    };
    for (const auto& [keys, expected] : rows) {
        const std::string project =
            "{instruments: [{name: I, port: p, exchanges: [{request: a, answer: {until: b, pattern: "
            "\"{v}\"}}], " +
            keys + "}]}";
        EXPECT_EQ(findings_text(interpret(document({.project = project}))), expected) << keys;
    }
    std::string many = "start: [";
    for (int i = 0; i < 33; ++i) many += "{request: a}, ";
    EXPECT_EQ(findings_text(interpret(document(
                  {.project = "{instruments: [{name: I, port: p, exchanges: [{answer: {until: b, pattern: "
                              "\"{v}\"}}], silent_after: 2, " +
                              many + "]}]}"}))),
              "?field.without_effect silent_after; field.out_of_range start");
}

}  // namespace source_test
}  // namespace takt::model::test
