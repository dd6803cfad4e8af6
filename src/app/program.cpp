// The command line: the options of docs/commands, read into the structures of the commands.
#include "program.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "log.hpp"
#include "options/add_commands.hpp"
#include "options/command_line.hpp"
#include "output.hpp"
#include "stop_signals.hpp"
#include "takt/model/nearest.hpp"
#include "texts.hpp"
#include "version.hpp"

namespace takt::app {
namespace {

using text::Language;

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

/// A command that a running program takes.
bool is_of_ctl(std::string_view command) {
    constexpr std::array<std::string_view, 7> kCommands{"status", "list",  "values", "get",
                                                        "set",    "fault", "quit"};
    return std::ranges::find(kCommands, command) != kCommands.end();
}

std::string unknown_command_text(const Texts& texts, const std::string& command,
                                 const std::vector<std::string>& commands) {
    const std::vector<std::string_view> candidates(commands.begin(), commands.end());
    const std::string nearest(model::nearest(command, candidates));
    // Two of the distance are one mistake.
    if (model::typing_distance(command, nearest) <= 2 * (command.size() / 3 + 1))
        return texts("app.unknown_command.near", {{"command", command}, {"nearest", nearest}});
    std::string known;
    for (const auto& one : commands) known += (known.empty() ? "" : ", ") + one;
    return texts("app.unknown_command", {{"command", command}, {"known", known}});
}

/// The error about the first of these arguments, or about the command of a group behind it; empty: none.
std::string command_error(const Texts& texts, const CommandLine& line, std::span<const std::string> given) {
    if (given.empty() || given[0].starts_with('-')) return {};
    const auto commands = line.commands();
    const auto& command = given[0];
    if (std::ranges::find(commands, command) == commands.end()) {
        if (is_of_ctl(command)) return texts("app.command_of_ctl", {{"command", command}});
        if (command == "new" || command == "init" || command == "create")
            return texts("app.command_new", {{"command", command}});
        return unknown_command_text(texts, command, commands);
    }
    const auto below = line.commands(command);
    if (below.empty() || given.size() < 2 || given[1].starts_with('-')) return {};
    const bool known = std::ranges::find(below, given[1]) != below.end();
    return known ? std::string() : unknown_command_text(texts, given[1], below);
}

}  // namespace

int run_program(int argc, char** argv) {
    accept_stop_signals();
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);  // a write beyond the limit of the file size fails instead
    CommandLine line("help.takt", "takt", "takt " + std::string(kProgramVersion));
    CommonOptions common;
    std::string language;
    auto root = line.root();
    root.value("--lang", language, "help.lang").one_of({"en", "ru", "uk"}).value_name("LANG");
    root.value("--log", common.log_file, "help.log").value_name("FILE");
    root.value("--log-level", common.log_level, "help.log_level")
        .one_of({"trace", "debug", "info", "warning", "error"})
        .value_name("LEVEL");
    add_running_commands(line, common);
    add_serve(line, common);
    add_project_commands(line, common);
    add_convert(line, common);
    add_table_commands(line, common);
    add_history(line, common);
    add_latency(line, common);
    add_capture_command(line, common);
    add_listen(line, common);
    add_replay(line, common);
    add_schema(line, common);
    add_selftest(line, common);
    add_client_commands(line, common);
    add_finding_commands(line, common);
    auto arguments = with_intervals(argc, argv);
    if (arguments.empty() && ::isatty(STDERR_FILENO) == 1) {
        print_status(Texts(language_of({}))("app.first_steps") + '\n');
        return static_cast<int>(ExitCode::usage);
    }
    const std::span given(arguments.begin() + static_cast<std::ptrdiff_t>(line.command_index(arguments)),
                          arguments.end());
    if (!given.empty() && given.front() == "help") {  // `takt help check` is `takt check --help`
        std::ranges::rotate(given, given.begin() + 1);
        given.back() = "--help";
    }
    // Where the parsing ends early, `language` is not set yet.
    const auto early_language = [&] { return language_of(wanted_language(argc, argv)); };
    if (const auto error = command_error(Texts(early_language()), line, given); !error.empty()) {
        print_error(error);
        return static_cast<int>(ExitCode::usage);
    }
    const auto parsed = line.parse(std::move(arguments), [&] { return Texts(early_language()); });
    if (parsed.asked == CommandLine::Asked::text) {
        print_wrapped(parsed.text);
        return end_status(early_language(), ExitCode::ok);
    }
    if (parsed.asked == CommandLine::Asked::nothing_valid) {
        const Texts texts(early_language());
        print_status(parsed.text);
        print_error(option_error_text(texts, parsed.error));
        if (parsed.text.empty()) print_status(texts("app.option.help") + '\n');
        return static_cast<int>(ExitCode::usage);
    }
    common.language = language_of(language);
    if (!common.log_file.empty()) {
        if (const auto begun = begin_log(common.log_file, common.log_level, common.language); !begun) {
            return static_cast<int>(ended_by(Texts(common.language), begun.error()));
        }
    }
    const ExitCode code = parsed.execute();
    end_log();
    return end_status(common.language, code);
}

}  // namespace takt::app
