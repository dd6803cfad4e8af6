// The register map of the servers of a project: what a master finds at which address.
#pragma once

#include <cstddef>
#include <string>

#include "takt/model/project.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// Number of used variables of all servers.
[[nodiscard]] std::size_t count_served(const model::Project& project);

/// One row per used variable, in the order of server, unit, area and address; RFC 4180 with headings that do
/// not depend on the language.
[[nodiscard]] std::string register_map_csv(const model::Project& project, char separator);

/// A table for each unit.
[[nodiscard]] std::string register_map_markdown(const Texts& texts, const model::Project& project);

}  // namespace takt::report
