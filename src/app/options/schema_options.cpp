// schema.
#include "commands/schema_command.hpp"
#include "options/add_commands.hpp"

namespace takt::app {

void add_schema(CommandLine& line, const CommonOptions& common) {
    line.root().command("schema", "help.schema", [&] { return app::schema(common); });
}

}  // namespace takt::app
