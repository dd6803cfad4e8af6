// One endpoint as a plain structure, and the pure functions that make it from a project or from options.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/endpoint/overrides.hpp"
#include "takt/line/target.hpp"
#include "takt/model/project.hpp"
#include "takt/serve/bank.hpp"
#include "takt/store/register_writer.hpp"

namespace takt::endpoint {

/// A TCP port or a serial port on which an endpoint answers.
struct ListenerSpec {
    /// With the transport, port, framing and character format in force. Its name and the names of its devices
    /// appear in a traffic log.
    model::Line line;
    std::optional<line::ListenAddress> address;  ///< TCP; nothing: the serial port of `line`
    bool strict = false;                         ///< RTU: pauses above t1.5 inside a frame spoil it
    Duration turnaround{};                       ///< serial: least time before an answer
    Duration byte_timeout{};                     ///< serial; zero: as serve::SerialConfig
    Duration frame_timeout{};                    ///< serial; zero: as serve::SerialConfig
    model::ListenLimits limits;                  ///< TCP
};

/// The units of a project's server; bound variables need the project's values (see Environment).
struct ServerUnits {
    std::vector<model::ServerUnit> units;
    sim::Fill fill = sim::Fill::zero;
};

/// The devices of a project's line, with moving values.
struct LineDevices {
    model::Line line;
};

/// The retained items of one unit.
struct RetainSpec {
    std::size_t unit = 0;                                   ///< index among the endpoint's own units
    std::array<std::vector<serve::AddressRange>, 4> items;  ///< by wire::Area
    store::Durability durability = store::Durability::acknowledged;
    std::string path;
};

/// One server: its listeners and units, its access rules, audit, retained registers and relays.
struct EndpointSpec {
    std::string name;
    std::vector<ListenerSpec> listeners;  ///< the same units answer on all of them
    std::variant<ServerUnits, LineDevices> units;
    std::vector<RetainSpec> retained;
    std::vector<model::AccessRule> access;  ///< empty: everybody may do everything
    bool access_is_override = false;        ///< `access` is Overrides::access, the same for all endpoints
    std::string audit;                      ///< file of writes and refusals; empty: none
    std::vector<model::Relay> relays;       ///< units of the project's lines; an own unit goes before them
};

/// The servers of a project.
/// @param project_file  the files of servers lie relative to it, or beside it
/// @param relays        whether the project's lines are there to relay to
[[nodiscard]] std::vector<EndpointSpec> server_endpoints(const model::Project& project,
                                                         const std::string& project_file,
                                                         const Overrides& overrides, bool relays);

/// The devices of the project, each line an endpoint, on the line's own port or on the port of the overrides
/// (then the project has one line).
/// @returns unsupported (a line that is neither serial nor tcp), and as line::parse_listen() and
///          parse_target()
[[nodiscard]] Result<std::vector<EndpointSpec>> device_endpoints(const model::Project& project,
                                                                 const Overrides& overrides);

/// A server of one unit with all items of the four areas, on all listeners that the overrides name.
/// @returns as line::parse_listen() and parse_target()
[[nodiscard]] Result<EndpointSpec> blank_endpoint(UnitId unit, const Overrides& overrides);

/// How many variables of servers are bound to variables of lines or to service variables, or written to
/// variables of lines.
[[nodiscard]] std::size_t bound_to_lines(const model::Project& project);

}  // namespace takt::endpoint
