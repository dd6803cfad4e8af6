// replay.
#include "commands/replay_command.hpp"
#include "options/add_commands.hpp"

namespace takt::app {

void add_replay(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<ReplayOptions>();
    auto replay = line.root().command("replay", "help.replay", [&] { return app::replay(common, options); });
    replay.value("FILE", options.file, "help.project").required();
    replay.value("--output", options.output, "help.replay.output").value_name("NAME").required();
    replay.value("--from", options.from, "help.replay.from").value_name("TIME").required();
    replay.flag("--json", options.json, "help.json");
}

}  // namespace takt::app
