// history and replay.
#include "commands.hpp"
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

void add_replay(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<ReplayOptions>();
    auto replay = line.root().command("replay", "help.replay", [&] { return app::replay(common, options); });
    replay.value("FILE", options.file, "help.project").required();
    replay.value("--output", options.output, "help.replay.output").value_name("NAME").required();
    replay.value("--from", options.from, "help.replay.from").value_name("TIME").required();
    replay.flag("--json", options.json, "help.json");
}

}  // namespace takt::app
