// selftest.
#include "commands/selftest_command.hpp"
#include "options/add_commands.hpp"
#include "options/shared_options.hpp"

namespace takt::app {

void add_selftest(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<SelftestOptions>();
    auto selftest =
        line.root().command("selftest", "help.selftest", [&] { return app::selftest(common, options); });
    add_wait(
        selftest, "--for", [&](Duration time) { options.time = time; }, "help.selftest.for")
        .default_text("5s");
    selftest.flag("--json", options.json, "help.json");
    add_realtime(selftest, options.realtime);
}

}  // namespace takt::app
