// history.
#include "commands/history_command.hpp"
#include "options/add_commands.hpp"

namespace takt::app {

void add_history(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<HistoryOptions>();
    auto history =
        line.root().command("history", "help.history", [&] { return app::history(common, options); });
    history.value("FILE", options.file, "help.project").required();
    history.value("VARIABLE", options.variables, "help.history.variables");
    history.value("--from", options.from, "help.history.from")
        .value_name("TIME")
        .one_value_each()
        .show_default();
    history.value("--to", options.to, "help.history.to").value_name("TIME").one_value_each().show_default();
    auto json = history.flag("--json", options.json, "help.json");
    auto csv = history.flag("--csv", options.csv, "help.history.csv").excludes(json);
    history.value("--svg", options.svg, "help.history.svg").value_name("FILE.svg").excludes(csv);
    history.value("--points", options.points, "help.history.points").range(1, 100'000).show_default();
    history.value("--database", options.database, "help.history.database").value_name("DB");
}

}  // namespace takt::app
