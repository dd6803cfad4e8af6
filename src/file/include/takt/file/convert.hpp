// Converts tables to project files and projects to tables.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "takt/file/load.hpp"
#include "takt/file/table.hpp"
#include "takt/model/document.hpp"
#include "takt/model/line.hpp"

namespace takt::file {

/// The keys of the line and the device that a table lacks, as texts of a project file.
struct Surroundings {
    std::vector<std::pair<std::string, std::string>> line;    ///< `name` among them
    std::vector<std::pair<std::string, std::string>> device;  ///< `name` and `address` among them
    /// connection_keys() of each text in kTargetColumn that is a target.
    std::map<std::string, std::vector<std::pair<std::string, std::string>>, std::less<>> connections = {};
    std::set<std::string> names = {};  ///< of variables of other devices in the project
};

/// The keys of a line of its connection, with their texts as in a project file: transport and
/// framing, then host and tcp_port, or port, bit rate and character format.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> connection_keys(const model::Line& line);

/// A project from the rows of load_tables(): a device for each name in kDeviceColumn, else the one of
/// `surroundings`, on the line of kLineColumn and kTargetColumn, and locals for the triggers and statuses
/// that the variables name. Locations stay those of the cells. Rows of several devices must have
/// kUnitAddressColumn. Devices without an address, and a second line without a target, are findings of the
/// result.
[[nodiscard]] Loaded project_of_table(Loaded table, const Surroundings& surroundings);

/// A project from tables of all kinds: locals, devices, and one server with one unit. A table of variables is
/// the device of its title, unless its rows name devices. `Устройство, 16` is the device Устройство with the
/// address 16; other titles get the address of `surroundings` or the next free one.
/// @param titles  of each table
[[nodiscard]] Loaded project_of_tables(LoadedTables tables, const Surroundings& surroundings,
                                       const std::vector<std::string>& titles);

/// A row of a table of devices with the keys of a device, and kProtocolColumn. The number of registers in a
/// request is left out where requests are not grouped.
[[nodiscard]] model::Node device_settings(const model::Node& row);

/// The locals of a project, and the variables of its servers, as rows of tables.
[[nodiscard]] std::vector<model::Node> rows_of_locals(const model::Document& document);
[[nodiscard]] std::vector<model::Node> rows_of_servers(const model::Document& document);

/// The rows of a table: the variables of all devices of a project, with kLineColumn, kDeviceColumn and
/// kUnitAddressColumn, and with kTargetColumn if there are several lines. Values inherited from the device
/// (period, byte orders) are written if they differ from the default, so the table is complete without the
/// project.
[[nodiscard]] std::vector<model::Node> rows_of_project(const model::Document& document);

/// The rows of one device without the columns that name it; nothing if no row names it.
[[nodiscard]] std::vector<model::Node> rows_of_device(const std::vector<model::Node>& rows,
                                                      const std::string& device);

/// The names of the devices in the rows, each once, in order of appearance.
[[nodiscard]] std::vector<std::string> devices_of(const std::vector<model::Node>& rows);

/// The lines of comments above items of lists, without `#`.
using Comments = std::map<const model::Node*, std::string>;

/// Writes the root of a document as a project file: lines and devices in block style, each variable and local
/// on one line. Reading it gives the same document. Precondition: model::interpret() finds no error.
[[nodiscard]] std::string write_project(const model::Node& root, const Comments& comments = {});

/// Likewise the keys of one device.
[[nodiscard]] std::string write_device_keys(const model::Node& device);

}  // namespace takt::file
