// check, plan, table and schema.
#include <map>
#include <string>

#include "commands.hpp"
#include "options/add_commands.hpp"
#include "options/shared_options.hpp"

namespace takt::app {
namespace {

void add_check(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<CheckOptions>();
    auto check = line.root().command("check", "help.check", [&] { return app::check(common, options); });
    check.value("FILE", options.file, "help.project").required();
    check.flag("--json", options.json, "help.json");
    check.flag("--no-notes", options.no_notes, "help.no_notes");
    auto prove = check.flag("--prove", options.prove, "help.prove");
    check.flag("--firmware", options.firmware, "help.check.firmware").excludes(prove);
}

void add_plan(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<PlanOptions>();
    auto plan = line.root().command("plan", "help.plan", [&] { return app::plan(common, options); });
    plan.value("FILE", options.file, "help.project").required();
    auto json = plan.flag("--json", options.json, "help.json");
    auto compare = plan.flag("--compare", options.compare, "help.plan.compare");
    auto csv = plan.flag("--csv", options.csv, "help.plan.csv").excludes(json).excludes(compare);
    plan.value("--svg", options.svg, "help.plan.svg").value_name("FILE.svg").excludes(csv);
    plan.flag("--no-notes", options.no_notes, "help.no_notes");
    plan.flag("--prove", options.prove, "help.prove_and_show");
    plan.flag("--fix", options.fix, "help.plan.fix");
}

void add_table_build(Command& table, CommandLine& line, const CommonOptions& common) {
    static const std::map<std::string, model::Profile> kProfiles{{"owen-kc1", model::Profile::owen_kc1}};
    auto& options = line.keep<TableBuildOptions>();
    auto build = table.command("build", "help.table.build", [&] { return table_build(common, options); });
    build.value("FILE", options.file, "help.project").required();
    build.value("-o,--output", options.output, "help.table.output").required().value_name("TABLE");
    add_word(build, "--profile", options.profile, kProfiles, "help.table.profile").value_name("PROFILE");
    build.flag("--no-names", options.no_names, "help.table.no_names");
}

void add_table_show(Command& table, CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<TableShowOptions>();
    auto show = table.command("show", "help.table.show", [&] { return table_show(common, options); });
    show.value("TABLE", options.file, "help.table.file").required();
    show.flag("--json", options.json, "help.json");
}

}  // namespace

void add_project_commands(CommandLine& line, const CommonOptions& common) {
    add_check(line, common);
    add_plan(line, common);
}

void add_table_commands(CommandLine& line, const CommonOptions& common) {
    auto table = line.root().group("table", "help.table");
    add_table_build(table, line, common);
    add_table_show(table, line, common);
}

void add_schema(CommandLine& line, const CommonOptions& common) {
    line.root().command("schema", "help.schema", [&] { return app::schema(common); });
}

}  // namespace takt::app
