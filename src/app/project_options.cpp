// check, plan and table.
#include "command_line.hpp"

namespace takt::app {
void add_project_commands(CLI::App& app, CommandLine& line) {
    auto& check =
        add_command(app, line, "check", "help.check", [&] { return app::check(line.common, line.check); });
    check.add_option("file", line.check.file, "help.project")->required()->type_name("FILE");
    check.add_flag("--json", line.check.json, "help.json");
    check.add_flag("--prove", line.check.prove, "help.prove");

    auto& plan =
        add_command(app, line, "plan", "help.plan", [&] { return app::plan(line.common, line.plan); });
    plan.add_option("file", line.plan.file, "help.project")->required()->type_name("FILE");
    plan.add_flag("--json", line.plan.json, "help.json");
    plan.add_flag("--compare", line.plan.compare, "help.plan.compare");
    plan.add_option("--svg", line.plan.svg, "help.plan.svg")->type_name("FILE.svg");
    plan.add_flag("--prove", line.plan.prove, "help.prove");
    plan.add_flag("--fix", line.plan.fix, "help.plan.fix");
}

void add_table_commands(CLI::App& app, CommandLine& line) {
    static const std::map<std::string, model::Profile> kProfiles{{"owen-kc1", model::Profile::owen_kc1}};
    CLI::App& table = *app.add_subcommand("table", "help.table");
    table.require_subcommand(1);
    table.fallthrough();

    auto& build = add_command(table, line, "build", "help.table.build",
                              [&] { return table_build(line.common, line.table_build); });
    build.add_option("file", line.table_build.file, "help.project")->required()->type_name("FILE");
    build.add_option("-o,--output", line.table_build.output, "help.table.output")
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
            "help.table.profile")
        ->type_name("PROFILE");
    build.add_flag("--no-names", line.table_build.no_names, "help.table.no_names");

    auto& show = add_command(table, line, "show", "help.table.show",
                             [&] { return table_show(line.common, line.table_show); });
    show.add_option("file", line.table_show.file, "Table")->required()->type_name("TABLE");
    show.add_flag("--json", line.table_show.json, "help.json");
}

}  // namespace takt::app
