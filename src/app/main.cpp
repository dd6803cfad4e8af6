// The command line: the options of docs/commands, read with CLI11 into the structures of commands.hpp.
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <sstream>

#include "command_line.hpp"
#include "help_texts.hpp"
#include "takt/app/console.hpp"
#include "takt/app/log.hpp"
#include "takt/app/option_error.hpp"
#include "takt/app/texts.hpp"

namespace takt::app {

CLI::App& add_command(CLI::App& app, CommandLine& line, const std::string& name, const std::string& help,
                      std::function<ExitCode()> execute) {
    CLI::App& command = *app.add_subcommand(name, help);
    command.fallthrough();
    command.callback([&line, execute = std::move(execute)] { line.chosen = execute; });
    return command;
}

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

/// The exit code, when all was done: what could not be written is told. A closed pipe is no failure: who
/// reads has read enough.
int end(Language language, ExitCode code) {
    for (const auto& [path, number] : {LostOutput{"stdout", stdout_error()}, lost_output()}) {
        if (number == 0 || number == EPIPE) continue;
        const Texts texts(language);
        print_error(texts.describe(fail(Code::io_failed, path, number).error()));
        if (code == ExitCode::ok) code = ExitCode::cannot_open;
    }
    return static_cast<int>(code);
}

int main_of(int argc, char** argv) {
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow fails its writer, who tells it
    CLI::App app("help.takt", "takt");
    app.set_version_flag("--version", "takt 0.1.0");
    app.require_subcommand(1);
    CommandLine line;
    std::string language;
    app.add_option("--lang", language, "help.lang")
        ->check(CLI::IsMember({"en", "ru", "uk"}))
        ->type_name("LANG");
    app.add_option("--log", line.common.log_file, "help.log")->type_name("FILE");
    app.add_option("--log-level", line.common.log_level, "help.log_level")
        ->check(CLI::IsMember({"trace", "debug", "info", "warning", "error"}))
        ->type_name("LEVEL");
    add_running_commands(app, line);
    add_serve(app, line);
    add_project_commands(app, line);
    add_convert(app, line);
    add_table_commands(app, line);
    add_client_commands(app, line);
    add_finding_commands(app, line);
    const auto commands = app.get_subcommands([](const CLI::App*) { return true; });
    if (argc > 1 && argv[1][0] != '-' && std::ranges::none_of(commands, [&](const CLI::App* command) {
            return command->get_name() == argv[1];
        })) {
        std::string known;
        for (const auto* command : commands) known += (known.empty() ? "" : ", ") + command->get_name();
        const Texts texts(language_of({}));
        print_error(texts("app.unknown_command", {{"command", argv[1]}, {"known", known}}));
        return static_cast<int>(ExitCode::usage);
    }
    try {
        auto arguments = with_intervals(argc, argv);
        std::ranges::reverse(arguments);
        app.parse(arguments);
    } catch (const CLI::Success& asked_for) {  // --help, --version
        const auto asked_in = language_of(wanted_language(argc, argv));
        put_into_words(app, Texts(asked_in));
        std::ostringstream text;
        app.exit(asked_for, text, text);
        print(text.str());
        return end(asked_in, ExitCode::ok);
    } catch (const CLI::ParseError& error) {
        // `--lang` may stand before or behind what is wrong, and then was not taken over yet.
        const Texts texts(language_of(wanted_language(argc, argv)));
        print_error(option_error(texts, error.what()));
        print_status(texts("app.option.help") + '\n');
        return static_cast<int>(ExitCode::usage);
    }
    line.common.language = language_of(language);
    if (!line.common.log_file.empty()) {
        if (const auto begun = begin_log(line.common.log_file, line.common.log_level); !begun) {
            return static_cast<int>(ended_by(Texts(line.common.language), begun.error()));
        }
    }
    const ExitCode code = line.chosen();
    end_log();
    return end(line.common.language, code);
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
