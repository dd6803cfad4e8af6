// takt table build and takt table show (docs/commands).
#pragma once

#include <optional>
#include <string>

#include "commands/common_options.hpp"
#include "exit_code.hpp"
#include "takt/model/project.hpp"

namespace takt::app {

struct TableBuildOptions {
    std::string file;
    std::string output;
    /// Nothing: Takt's own format, which holds any plan. owen_kc1: the project is read as of that profile,
    /// and the table is the controller's.
    std::optional<model::Profile> profile;
    bool no_names = false;  ///< Takt's own format without texts
};

struct TableShowOptions {
    std::string file;
    bool json = false;
};

ExitCode table_build(const CommonOptions& common, const TableBuildOptions& options);
ExitCode table_show(const CommonOptions& common, const TableShowOptions& options);

}  // namespace takt::app
