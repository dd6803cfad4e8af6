// YAML to nodes.
#pragma once

#include <cstddef>
#include <optional>

#include "takt/model/document.hpp"
#include "yaml/reporter.hpp"
#include "yaml/source.hpp"

namespace takt::file {

/// Reads the only document of a text without foreign characters. Every node reduces `nodes_left`.
/// @returns nothing if the document is incomplete. Errors are reported in both cases
std::optional<model::Node> read_yaml(const Source& source, std::size_t& nodes_left, Reporter& reporter);

}  // namespace takt::file
