#include "commands.hpp"

#include "output.hpp"
#include "takt/file/schema.hpp"

namespace takt::app {

ExitCode schema(const CommonOptions&) {
    print(file::project_schema().dump(2) + '\n');
    return ExitCode::ok;
}

}  // namespace takt::app
