// The command line: what docs/cli.md says, read with CLI11 into the structures of commands.hpp.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <map>

#include "common_options.hpp"
#include "takt/app/commands.hpp"
#include "takt/app/log.hpp"
#include "takt/app/option_error.hpp"
#include "takt/app/texts.hpp"

namespace takt::app {
namespace {

using text::Language;

struct CommandLine {
    CommonOptions common;
    CheckOptions check;
    ConvertOptions convert;
    PlanOptions plan;
    RunOptions run;
    DemoOptions demo;
    ServeOptions serve;
    ReadOptions read;
    WriteOptions write;
    RawOptions raw;
    ScanOptions scan;
    ProbeOptions probe;
    TableBuildOptions table_build;
    TableShowOptions table_show;
    CtlOptions ctl;
    std::function<ExitCode()> chosen;
};

CLI::App& add_command(CLI::App& app, CommandLine& line, const std::string& name, const std::string& help,
                      std::function<ExitCode()> execute) {
    CLI::App& command = *app.add_subcommand(name, help);
    command.fallthrough();
    command.callback([&line, execute = std::move(execute)] { line.chosen = execute; });
    return command;
}

void add_project_commands(CLI::App& app, CommandLine& line) {
    auto& check = add_command(app, line, "check", "Check a project: every finding with its place and advice",
                              [&] { return app::check(line.common, line.check); });
    check.add_option("file", line.check.file, "Project file")->required()->type_name("FILE");
    check.add_flag("--json", line.check.json, "Print one JSON object");
    check.add_flag("--prove", line.check.prove, "A deadline that is not proved is an error");

    auto& plan = add_command(app, line, "plan", "Show the requests that will be sent, and why",
                             [&] { return app::plan(line.common, line.plan); });
    plan.add_option("file", line.plan.file, "Project file")->required()->type_name("FILE");
    plan.add_flag("--json", line.plan.json, "Print one JSON object");
    plan.add_flag("--compare", line.plan.compare,
                  "The strategies beside each other: single, classic, optimal");
    plan.add_option("--svg", line.plan.svg, "Draw the plan into this file (-: stdout, instead of the text)")
        ->type_name("FILE.svg");
    plan.add_flag("--prove", line.plan.prove, "A deadline that is not proved is an error");
    plan.add_flag("--fix", line.plan.fix,
                  "Plan again with time-outs, splitting or grouping that hold; the file stays as it is");
}

const std::map<std::string, FileKind> kFileKinds{{"csv", FileKind::csv}, {"yaml", FileKind::yaml}};
const std::map<std::string, char> kSeparators{
    {"comma", ','}, {"semicolon", ';'}, {"tab", '\t'}, {",", ','}, {";", ';'}};
const std::map<std::string, file::Addresses> kAddresses{{"zero-based", file::Addresses::zero_based},
                                                        {"reference", file::Addresses::reference},
                                                        {"auto", file::Addresses::automatic}};
const std::map<std::string, file::Headings> kHeadings{{"keys", file::Headings::keys},
                                                      {"en", file::Headings::english},
                                                      {"ru", file::Headings::russian},
                                                      {"uk", file::Headings::ukrainian}};

void add_encoding(CLI::App& command, const std::string& name, std::optional<file::Encoding>& encoding,
                  bool* byte_order_mark, const std::string& help) {
    command
        .add_option_function<std::string>(
            name,
            [&encoding, byte_order_mark](const std::string& text) {
                encoding = text == "cp1251" ? file::Encoding::cp1251 : file::Encoding::utf8;
                if (byte_order_mark != nullptr) *byte_order_mark = text == "utf-8-bom";
            },
            help)
        ->check(CLI::IsMember({"utf-8", "utf-8-bom", "cp1251"}))
        ->type_name("ENCODING");
}

void add_convert(CLI::App& app, CommandLine& line) {
    auto& options = line.convert;
    auto& convert =
        add_command(app, line, "convert", "A CSV table to a project or to another table, a project to CSV",
                    [&] { return app::convert(line.common, line.convert); });
    convert.add_option("input", options.input, "Table (.csv) or project (.yaml)")
        ->required()
        ->type_name("IN");
    convert.add_option("-o,--output", options.output, "File to write (.csv, .yaml); else stdout")
        ->type_name("OUT");
    convert.add_flag("--force", options.force, "Overwrite OUT");
    add_word(convert, "--from", options.from, kFileKinds, "What IN is: csv, yaml (else by its ending)")
        ->type_name("KIND");
    add_word(convert, "--to", options.to, kFileKinds, "What OUT is: csv, yaml (else by its ending)")
        ->type_name("KIND");
    convert.add_option("--line", options.line, "Name of the line of a new project")->capture_default_str();
    convert.add_option(
        "--device", options.device,
        "The device to take; name of the device of a new project (else IN without its ending)");
    convert
        .add_option_function<int>(
            "--unit", [&](int unit) { options.unit = static_cast<std::uint8_t>(unit); },
            "Unit address of the device of a new project (else 1)")
        ->check(CLI::Range(0, 255));
    convert.add_option("--target", options.target, "Where the device of a new project is, as for takt read")
        ->type_name("TARGET")
        ->capture_default_str();
    options.reading.addresses = file::Addresses::automatic;
    add_word(convert, "--addresses", options.reading.addresses, kAddresses,
             "Register addresses of a table: zero-based (on the wire), reference (40001), auto (default)")
        ->type_name("NOTATION");
    add_word(convert, "--headings", options.writing.headings, kHeadings,
             "First line of a written table: keys (default), en, ru, uk")
        ->type_name("HEADINGS");
    add_word(convert, "--separator", options.separator, kSeparators,
             "comma, semicolon, tab of the written table; without one, of the read table")
        ->type_name("SEPARATOR");
    add_encoding(convert, "--encoding", options.encoding, &options.byte_order_mark,
                 "utf-8, utf-8-bom, cp1251 of the written table; without one, of the read table");
    add_word(convert, "--input-separator", options.reading.separator, kSeparators,
             "The same of the read table (else found by itself)")
        ->type_name("SEPARATOR");
    add_encoding(convert, "--input-encoding", options.reading.encoding, nullptr,
                 "The same of the read table (else found by itself)");
}

void add_running_commands(CLI::App& app, CommandLine& line) {
    auto& demo = add_command(app, line, "demo",
                             "A simulated RS-485 line with three devices, polled by the real master",
                             [&] { return app::demo(line.common, line.demo); });
    add_duration(
        demo, "--for", [&](Duration time) { line.demo.run_for = time; }, "Stop after this time, as in 10s");
    demo.add_flag("--json", line.demo.json, "Print one JSON object a line");

    auto& run =
        add_command(app, line, "run", "Poll a project", [&] { return app::run(line.common, line.run); });
    auto* file = run.add_option("file", line.run.file, "Project file")->type_name("FILE");
    auto* table = run.add_option("--table", line.run.table, "Run this request table instead of a project")
                      ->type_name("TABLE");
    table->excludes(file);
    run.add_option("--port", line.run.place, "With --table: another serial port, or HOST:PORT")
        ->needs(table)
        ->type_name("PORT");
    run.callback([&line] {
        if (line.run.file.empty() && line.run.table.empty())
            throw CLI::RequiredError("FILE or --table TABLE");
        line.chosen = [&line] { return app::run(line.common, line.run); };
    });
    add_duration(
        run, "--for", [&](Duration time) { line.run.run_for = time; }, "Stop after this time, as in 10s");
    run.add_flag("--json", line.run.json, "Print one JSON object a line");
    run.add_option("--traffic", line.run.traffic, "Write every frame to this file (-: stderr)")
        ->type_name("FILE");
    run.add_flag("--stdin", line.run.commands_from_stdin,
                 "Read commands from standard input: set, write, get, quit");
    run.add_option("--control", line.run.control_path,
                   "Take the same commands on a Unix socket (see takt ctl)")
        ->type_name("PATH");

    run.add_option("--state", line.run.state,
                   "File of the retained values (default: beside the project, PLANT.state)")
        ->type_name("FILE");

    auto& ctl = add_command(app, line, "ctl", "Send a command to a running project: set, write, get, quit",
                            [&] { return app::ctl(line.common, line.ctl); });
    ctl.add_option("path", line.ctl.path, "Socket of takt run --control")->required()->type_name("PATH");
    ctl.add_option("command", line.ctl.words, "set NAME VALUE | write NAME VALUE | get NAME | quit")
        ->required()
        ->type_name("COMMAND");

    static const std::map<std::string, sim::Fill> kFills{
        {"zero", sim::Fill::zero}, {"ramp", sim::Fill::ramp}, {"random", sim::Fill::random}};
    auto& serve = add_command(app, line, "serve", "Be the devices of a project, or a blank device",
                              [&] { return app::serve(line.common, line.serve); });
    serve.add_option("file", line.serve.file, "Project file whose devices to be")->type_name("FILE");
    serve.add_option("--listen", line.serve.listen, "Serve Modbus TCP here, as in 127.0.0.1:1502")
        ->type_name("HOST:PORT");
    serve.add_option("--port", line.serve.port, "Serve on this serial port or serial target")
        ->type_name("PORT");
    serve.add_option("--unit", line.serve.unit, "Unit address of the blank device")
        ->check(CLI::Range(0, 255))
        ->capture_default_str();
    add_word(serve, "--fill", line.serve.fill, kFills, "Contents of the blank device: zero, ramp, random")
        ->type_name("FILL");
    add_duration(
        serve, "--for", [&](Duration time) { line.serve.run_for = time; }, "Stop after this time, as in 10s");
    serve.add_option("--traffic", line.serve.traffic, "Write every frame to this file (-: stderr)")
        ->type_name("FILE");
}

void add_table_commands(CLI::App& app, CommandLine& line) {
    static const std::map<std::string, model::Profile> kProfiles{{"owen-kc1", model::Profile::owen_kc1}};
    CLI::App& table = *app.add_subcommand("table", "The plan compiled to a binary image: build, show");
    table.require_subcommand(1);
    table.fallthrough();

    auto& build = add_command(table, line, "build", "Compile a project to a request table",
                              [&] { return table_build(line.common, line.table_build); });
    build.add_option("file", line.table_build.file, "Project file")->required()->type_name("FILE");
    build.add_option("-o,--output", line.table_build.output, "Table to write")
        ->required()
        ->type_name("TABLE");
    build
        .add_option_function<std::string>(
            "--profile",
            [&line](const std::string& text) {
                const auto found = kProfiles.find(text);
                if (found == kProfiles.end())
                    throw CLI::ValidationError("--profile", "'" + text + "' is not known, allowed: owen-kc1");
                line.table_build.profile = found->second;
            },
            "owen-kc1: exactly the entries that controller has; what they cannot hold is refused by name")
        ->type_name("PROFILE");
    build.add_flag("--no-names", line.table_build.no_names, "Without texts, for small controllers");

    auto& show = add_command(table, line, "show", "Show what is in a request table",
                             [&] { return table_show(line.common, line.table_show); });
    show.add_option("file", line.table_show.file, "Table")->required()->type_name("TABLE");
    show.add_flag("--json", line.table_show.json, "Print one JSON object");
}

/// AREA:START[:COUNT]
WatchedRange watched_range(const std::string& text) {
    const auto wrong = [&] {
        return CLI::ValidationError("--also",
                                    "'" + text + "' is not known, allowed: AREA:START, AREA:START:COUNT");
    };
    const auto colon = text.find(':');
    const auto area = kAreas.find(text.substr(0, colon));
    if (area == kAreas.end() || colon == std::string::npos) throw wrong();
    const auto number = [&](const std::string& digits, std::uint64_t least, std::uint64_t greatest) {
        const bool good = !digits.empty() && digits.size() <= 5 &&
                          digits.find_first_not_of("0123456789") == std::string::npos;
        const auto value = good ? std::stoul(digits) : 0;
        if (!good || value < least || value > greatest) throw wrong();
        return value;
    };
    const auto second = text.find(':', colon + 1);
    WatchedRange range;
    range.area = area->second;
    range.start = static_cast<std::uint16_t>(number(text.substr(colon + 1, second - colon - 1), 0, 65535));
    if (second != std::string::npos)
        range.count = static_cast<std::uint32_t>(number(text.substr(second + 1), 1, 65536));
    return range;
}

void add_watch(CLI::App& read, ReadOptions& options) {
    auto* watch = add_duration(
        read, "--watch",
        [&options](Duration interval) {
            if (interval < std::chrono::milliseconds(1))
                throw CLI::ValidationError("--watch", "the least is 1ms");
            options.watch = interval;
            options.reconnect = true;
        },
        "Read again and again, each INTERVAL (1s where none is given), until Ctrl-C");
    watch->type_name("[INTERVAL]");
    add_duration(
        read, "--for", [&options](Duration time) { options.run_for = time; },
        "With --watch: stop after this time")
        ->needs(watch);
    read.add_flag("--changes", options.changes, "With --watch: tell changes alone")->needs(watch);
    read.add_option_function<std::vector<std::string>>(
            "--also",
            [&options](const std::vector<std::string>& ranges) {
                for (const auto& range : ranges) options.also.push_back(watched_range(range));
            },
            "With --watch: another range")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
        ->needs(watch)
        ->type_name("AREA:START[:COUNT]");
}

/// `--watch` may stand alone: it gets its interval from what follows only where that is a duration.
std::vector<std::string> with_intervals(int argc, char** argv) {
    std::vector<std::string> arguments;
    for (int i = 1; i < argc; ++i) {
        arguments.emplace_back(argv[i]);
        if (arguments.back() != "--watch") continue;
        const std::string next = i + 1 < argc ? argv[i + 1] : "";
        const auto unit = next.find_first_not_of("0123456789.");
        const bool interval = unit != std::string::npos && unit > 0;
        arguments.back() += '=' + (interval ? next : "1s");
        if (interval) ++i;
    }
    return arguments;
}

void add_client_commands(CLI::App& app, CommandLine& line) {
    auto& read = add_command(app, line, "read", "Read values from a device",
                             [&] { return app::read(line.common, line.read); });
    add_client(read, line.read);
    add_word(read, "area", line.read.area, kAreas, "coils, discrete, input, holding")
        ->required()
        ->type_name("AREA");
    read.add_option("start", line.read.start, "Zero-based address on the wire")
        ->required()
        ->type_name("START");
    read.add_option("count", line.read.count, "How many values")
        ->check(CLI::Range(1, 65536))
        ->type_name("COUNT");
    add_type(read, line.read.type, line.read.registers_only);
    read.add_option("--length", line.read.string_registers, "Registers of a string")
        ->check(CLI::Range(1, 125));
    add_order(read, line.read.order);
    add_watch(read, line.read);

    auto& write = add_command(app, line, "write", "Write values to a device",
                              [&] { return app::write(line.common, line.write); });
    add_client(write, line.write);
    add_word(write, "area", line.write.area, kAreas, "coils, holding")->required()->type_name("AREA");
    write.add_option("start", line.write.start, "Zero-based address on the wire")
        ->required()
        ->type_name("START");
    write.add_option("values", line.write.values, "Values in the order of their addresses")
        ->required()
        ->type_name("VALUE");
    add_type(write, line.write.type, line.write.registers_only);
    add_order(write, line.write.order);
    write.add_flag("--multiple", line.write.multiple, "Use 0x0F / 0x10 also for a single value");

    auto& raw = add_command(app, line, "raw", "Send a PDU given in hexadecimal",
                            [&] { return app::raw(line.common, line.raw); });
    add_client(raw, line.raw);
    raw.add_option("bytes", line.raw.bytes, "The PDU, as in 03 00 00 00 02")->required()->type_name("HEX");
}

void add_scan(CLI::App& app, CommandLine& line) {
    auto& options = line.scan;
    auto& scan =
        add_command(app, line, "scan", "Find the devices on a serial line, behind a gateway, on hosts",
                    [&] { return app::scan(line.common, line.scan); });
    scan.add_option(
            "target", options.targets,
            "Ports and hosts, as for takt read; ranges of hosts: tcp://10.0.0.1-20, tcp://10.0.0.0/24")
        ->required()
        ->expected(1, 64)
        ->type_name("TARGET");
    scan.add_option("--units", options.units, "Unit addresses, as in 1-10,16")
        ->type_name("LIST")
        ->capture_default_str();
    scan.add_option("--bauds", options.bauds,
                    "Bit rates to try, as in 9600,19200 (default: the target's, else the five usual ones)")
        ->type_name("LIST");
    scan.add_option("--parities", options.parities,
                    "Parities to try: none,even,odd (default: the target's, else all three)")
        ->type_name("LIST");
    scan.add_option("--stop-bits", options.stop_bits, "Stop bits to try: 1,2 (default: the target's, else 1)")
        ->type_name("LIST");
    add_timeout(scan, options.timeout,
                "Longest wait for an answer (default 100ms on serial lines, 1s elsewhere)");
    scan.add_flag("--first", options.first,
                  "Leave a port after the first line settings with which something was found");
    scan.add_flag("--thorough", options.thorough, "Ask silent units by functions 4, 1 and 43 too");
    scan.add_flag("!--no-identify", options.identify, "Do not ask what the devices are");
    scan.add_flag("--json", options.json, "Print one JSON object at the end");
    scan.add_option("--project", options.project, "Write a project of what was found")
        ->type_name("FILE.yaml");
    scan.add_flag("--force", options.force, "Overwrite FILE.yaml");
    scan.add_option("--traffic", options.traffic, "Write every frame to this file (-: stderr)")
        ->type_name("FILE");
}

void add_probe(CLI::App& app, CommandLine& line) {
    auto& options = line.probe;
    options.attempts = 2;
    options.reconnect = true;
    auto& probe =
        add_command(app, line, "probe", "Find out which registers and coils a device has; reads only",
                    [&] { return app::probe(line.common, line.probe); });
    add_client(probe, options);
    probe
        .add_option_function<std::string>(
            "--area",
            [&options](const std::string& words) {
                for (std::size_t begin = 0; begin <= words.size();) {
                    const auto end = std::min(words.find(',', begin), words.size());
                    const auto found = kAreas.find(words.substr(begin, end - begin));
                    if (found == kAreas.end())
                        throw CLI::ValidationError(
                            "--area",
                            "'" + words + "' is not known, allowed: coils, discrete, holding, input");
                    options.areas.push_back(found->second);
                    begin = end + 1;
                }
            },
            "coils, discrete, input, holding, or several with commas (default: all four)")
        ->type_name("AREA");
    probe.add_option("--from", options.first, "First address to look at")->capture_default_str();
    probe.add_option("--to", options.last, "Last address to look at")->capture_default_str();
    probe
        .add_option_function<int>(
            "--step", [&](int step) { options.step = static_cast<std::uint16_t>(step); },
            "Where nothing answers look at every so many-th address (default: 1 where --max-requests allow "
            "it)")
        ->check(CLI::Range(1, 65535))
        ->type_name("N");
    probe.add_option("--max-requests", options.max_requests, "Most requests for each area")
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    probe.add_flag("--yaml", options.yaml, "Print `readable`, ready for a project");
}

Language language_of(const std::string& option) {
    const auto variable = [](const char* name) {
        const char* value = std::getenv(name);
        return value ? std::string_view(value) : std::string_view();
    };
    const auto from_environment = text::language(text::Environment{.language = variable("LANGUAGE"),
                                                                   .lc_all = variable("LC_ALL"),
                                                                   .lc_messages = variable("LC_MESSAGES"),
                                                                   .lang = variable("LANG")});
    return text::language(option).value_or(from_environment);
}

std::string wanted_language(int argc, char** argv) {
    constexpr std::string_view kOption = "--lang";
    for (int i = 1; i < argc; ++i) {
        const std::string_view argument = argv[i];
        if (argument == kOption && i + 1 < argc) return argv[i + 1];
        if (argument.starts_with("--lang=")) return std::string(argument.substr(kOption.size() + 1));
    }
    return {};
}

int main_of(int argc, char** argv) {
    std::signal(SIGPIPE, SIG_IGN);
    CLI::App app("Takt: plans, polls and answers Modbus.", "takt");
    app.set_version_flag("--version", "takt 0.1.0");
    app.require_subcommand(1);
    CommandLine line;
    std::string language;
    app.add_option("--lang", language, "Language of messages: en, ru, uk")
        ->check(CLI::IsMember({"en", "ru", "uk"}))
        ->type_name("LANG");
    app.add_option("--log", line.common.log_file, "Write the log to this file")->type_name("FILE");
    app.add_option("--log-level", line.common.log_level, "trace, debug, info, warning, error")
        ->check(CLI::IsMember({"trace", "debug", "info", "warning", "error"}))
        ->type_name("LEVEL");
    add_running_commands(app, line);
    add_project_commands(app, line);
    add_convert(app, line);
    add_table_commands(app, line);
    add_client_commands(app, line);
    add_scan(app, line);
    add_probe(app, line);
    const auto commands = app.get_subcommands([](const CLI::App*) { return true; });
    if (argc > 1 && argv[1][0] != '-' && std::ranges::none_of(commands, [&](const CLI::App* command) {
            return command->get_name() == argv[1];
        })) {
        std::string known;
        for (const auto* command : commands) known += (known.empty() ? "" : ", ") + command->get_name();
        const Texts texts(language_of({}));
        texts.complain(texts("app.unknown_command", {{"command", argv[1]}, {"known", known}}));
        return static_cast<int>(ExitCode::usage);
    }
    try {
        auto arguments = with_intervals(argc, argv);
        std::ranges::reverse(arguments);
        app.parse(arguments);
    } catch (const CLI::Success& asked_for) {  // --help, --version
        app.exit(asked_for);
        return static_cast<int>(ExitCode::ok);
    } catch (const CLI::ParseError& error) {
        // `--lang` may stand before or behind what is wrong, and then was not taken over yet.
        const Texts texts(language_of(wanted_language(argc, argv)));
        texts.complain(option_error(texts, error.what()));
        talk(texts("app.option.help") + '\n');
        return static_cast<int>(ExitCode::usage);
    }
    line.common.language = language_of(language);
    if (!line.common.log_file.empty()) {
        if (const auto begun = begin_log(line.common.log_file, line.common.log_level); !begun) {
            const Texts texts(line.common.language);
            texts.complain(texts.describe(begun.error()));
            return static_cast<int>(exit_code(begun.error()));
        }
    }
    const ExitCode code = line.chosen();
    end_log();
    if (code == ExitCode::ok && print_error() != 0 && print_error() != EPIPE) {
        const Texts texts(line.common.language);
        texts.complain(texts.describe(fail(Code::io_failed, "stdout", print_error()).error()));
        return static_cast<int>(ExitCode::cannot_open);
    }
    return static_cast<int>(code);
}

}  // namespace
}  // namespace takt::app

int main(int argc, char** argv) {
    try {
        return takt::app::main_of(argc, argv);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "takt: internal error: %s\n", error.what());
        return static_cast<int>(takt::app::ExitCode::usage);
    }
}
