// From a table to a project file, and from a project to the rows of a table.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "takt/file/load.hpp"
#include "takt/file/table.hpp"
#include "takt/model/document.hpp"
#include "takt/model/line.hpp"

namespace takt::file {

/// What a table does not say: keys of the line and of the device with their texts as in a project file.
struct Surroundings {
    std::vector<std::pair<std::string, std::string>> line;    ///< `name` among them
    std::vector<std::pair<std::string, std::string>> device;  ///< `name` and `address` among them
};

/// The keys of a line of its connection, with their texts as in a project file: transport and
/// framing, then host and tcp_port, or port, bit rate and character format.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> connection_keys(const model::Line& line);

/// A project of one line around the rows of load_table(): a device for each name in kDeviceColumn, else the
/// one of `surroundings`; locals for the triggers and statuses that the variables name. Places stay those of
/// the cells. What cannot be put together (several lines; several devices without their addresses) is among
/// the findings of the result. Rows of several devices must carry kUnitAddressColumn.
[[nodiscard]] Loaded project_of_table(Loaded table, const Surroundings& surroundings);

/// The rows for a table: the variables of all devices of a project as it stands in its document, with
/// kLineColumn, kDeviceColumn and kUnitAddressColumn. What a variable takes from its device (period, byte
/// orders) stands in its row where it is not the default: the table means the same without the project.
[[nodiscard]] std::vector<model::Node> rows_of_project(const model::Document& document);

/// The rows of one device, without the columns that name it; nothing selected when no row names it.
[[nodiscard]] std::vector<model::Node> rows_of_device(const std::vector<model::Node>& rows,
                                                      const std::string& device);

/// The names of the devices in the rows, each once, in their order.
[[nodiscard]] std::vector<std::string> devices_of(const std::vector<model::Node>& rows);

/// A document of project_of_table() as a project file: lines and devices in blocks, a variable and a local on
/// a line. Reading it gives the same document. Its scalars must fit their fields (model::interpret() found no
/// error).
[[nodiscard]] std::string write_project(const model::Document& document);

}  // namespace takt::file
