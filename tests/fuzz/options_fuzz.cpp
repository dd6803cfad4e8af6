// Arbitrary arguments to the command line. They are parsed and not executed.
#include <cstddef>
#include <string>
#include <vector>

#include "input.hpp"
#include "options/add_commands.hpp"
#include "options/command_line.hpp"
#include "texts.hpp"

namespace {

using namespace takt;

// Names of commands and options, so that the parser goes on to values and to options that exclude each other.
constexpr const char* kWords[] = {
    "check",    "plan",     "run",       "demo",      "serve",     "read",    "write",
    "raw",      "scan",     "probe",     "table",     "build",     "show",    "ctl",
    "convert",  "--json",   "--help",    "--for",     "--unit",    "--units", "--lang",
    "--to",     "--from",   "--svg",     "--fix",     "--compare", "--prove", "--no-notes",
    "--listen", "--strict", "--fill",    "--watch",   "--type",    "holding", "-1",
    "65536",    "10s",      "1..247",    "tcp://h:1", "--",        "",        "rtu:///dev/ttyS0?baud=9600",
    "a.yaml",   "--state",  "--control", "--stdin",   "--traffic", "--log",   "--profile",
};

std::vector<std::string> arguments_of(fuzz::Input& input) {
    std::vector<std::string> arguments{"takt"};
    while (!input.empty() && arguments.size() < 32) {
        const std::uint8_t choice = input.byte();
        if (choice < 192) {
            arguments.emplace_back(kWords[choice % std::size(kWords)]);
            continue;
        }
        const Bytes bytes = input.bytes(choice - 192);
        std::string text(bytes.begin(), bytes.end());
        std::erase(text, '\0');
        if (choice % 4 == 0 && arguments.size() > 1)
            arguments.back() += "=" + text;
        else
            arguments.push_back(text);
    }
    return arguments;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Input input({data, size});
    auto arguments = arguments_of(input);
    std::vector<char*> argv;
    for (auto& argument : arguments) argv.push_back(argument.data());
    app::CommandLine line("help.takt", "takt", "takt");
    const app::CommonOptions common;
    app::add_running_commands(line, common);
    app::add_serve(line, common);
    app::add_project_commands(line, common);
    app::add_convert(line, common);
    app::add_table_commands(line, common);
    app::add_client_commands(line, common);
    app::add_finding_commands(line, common);
    const app::Texts texts(text::Language::english);
    const auto parsed =
        line.parse(app::with_intervals(static_cast<int>(argv.size()), argv.data()), [&] { return texts; });
    switch (parsed.asked) {
        case app::CommandLine::Asked::command: fuzz::require(static_cast<bool>(parsed.execute)); break;
        case app::CommandLine::Asked::text: fuzz::require(!parsed.text.empty()); break;
        case app::CommandLine::Asked::nothing_valid:
            fuzz::require(!texts(parsed.error.code, parsed.error.arguments).empty());
            break;
    }
    return 0;
}
