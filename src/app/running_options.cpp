// demo, run and ctl.
#include "command_line.hpp"

namespace takt::app {
namespace {

void add_demo(CLI::App& app, CommandLine& line) {
    auto& demo =
        add_command(app, line, "demo", "help.demo", [&] { return app::demo(line.common, line.demo); });
    add_duration(demo, "--for", [&](Duration time) { line.demo.run_for = time; }, "help.for");
    demo.add_flag("--json", line.demo.json, "help.json.lines");
}

void add_run(CLI::App& app, CommandLine& line) {
    auto& run = add_command(app, line, "run", "help.run", [&] { return app::run(line.common, line.run); });
    auto* file = run.add_option("file", line.run.file, "help.project")->type_name("FILE");
    auto* table = run.add_option("--table", line.run.table, "help.run.table")->type_name("TABLE");
    table->excludes(file);
    run.add_option("--port", line.run.place, "help.run.port")->needs(table)->type_name("PORT");
    run.callback([&line] {
        if (line.run.file.empty() && line.run.table.empty())
            throw CLI::RequiredError("FILE or --table TABLE");
        line.chosen = [&line] { return app::run(line.common, line.run); };
    });
    add_duration(run, "--for", [&](Duration time) { line.run.run_for = time; }, "help.for");
    run.add_flag("--json", line.run.json, "help.json.lines");
    run.add_option("--traffic", line.run.traffic, "help.traffic")->type_name("FILE");
    run.add_flag("--stdin", line.run.commands_from_stdin, "help.run.stdin");
    run.add_option("--control", line.run.control_path, "help.run.control")->type_name("PATH");

    run.add_option("--state", line.run.state, "help.run.state")->type_name("FILE");
}

void add_ctl(CLI::App& app, CommandLine& line) {
    auto& ctl = add_command(app, line, "ctl", "help.ctl", [&] { return app::ctl(line.common, line.ctl); });
    ctl.add_option("path", line.ctl.path, "help.ctl.path")->required()->type_name("PATH");
    ctl.add_option("command", line.ctl.words, "help.ctl.command")->required()->type_name("COMMAND");
}

}  // namespace

void add_running_commands(CLI::App& app, CommandLine& line) {
    add_demo(app, line);
    add_run(app, line);
    add_ctl(app, line);
}

}  // namespace takt::app
