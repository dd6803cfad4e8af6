// takt convert (docs/commands).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "commands/common_options.hpp"
#include "exit_code.hpp"
#include "takt/file/table.hpp"

namespace takt::app {

/// The kind of a file; by default its name ends with it.
enum class FileKind : std::uint8_t { by_ending, csv, yaml, markdown };

struct ConvertOptions {
    std::vector<std::string> inputs;  ///< several: tables of one project
    std::string output;               ///< empty: stdout
    FileKind from = FileKind::by_ending;
    FileKind to = FileKind::by_ending;
    bool force = false;  ///< overwrite what is there
    // of tables
    file::TableKind table = file::TableKind::variables;  ///< of a project: which one
    bool table_given = false;
    bool map = false;  ///< of a project: the registers of its servers
    file::TableOptions reading;
    bool addresses_given = false;
    bool notation_given = false;
    file::TableFormat writing;
    std::optional<file::Encoding> encoding;  ///< of the one table there is, or of the one that is written
    bool byte_order_mark = false;
    char separator = 0;  ///< likewise
    // of the project around a table
    std::string line = "line";
    std::string device;  ///< also: the only one to be taken
    std::optional<std::uint8_t> unit;
    std::string target = "rtu:///dev/ttyUSB0";
};

ExitCode convert(const CommonOptions& common, const ConvertOptions& options);

}  // namespace takt::app
