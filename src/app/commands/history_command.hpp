// takt history (docs/commands).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "commands/common_options.hpp"
#include "exit_code.hpp"

namespace takt::app {

struct HistoryOptions {
    std::string file;                    ///< the project
    std::vector<std::string> variables;  ///< empty: list them
    std::string from = "-1h";
    std::string to = "now";
    std::string database;  ///< empty: publish::history_database() of the project
    bool json = false;
    bool csv = false;
    std::string svg;  ///< file for the picture; "-": stdout
    std::uint32_t points = 1000;
};

ExitCode history(const CommonOptions& common, const HistoryOptions& options);

}  // namespace takt::app
