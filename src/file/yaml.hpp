// YAML to nodes.
#pragma once

#include <cstddef>
#include <optional>

#include "reporter.hpp"
#include "source.hpp"
#include "takt/model/document.hpp"

namespace takt::file {

/// Reads the one document of a text without foreign characters. Each node is taken from `nodes_left`.
/// nullopt when it cannot be read whole; what is wrong stands in the reporter either way.
std::optional<model::Node> read_yaml(const Source& source, std::size_t& nodes_left, Reporter& reporter);

}  // namespace takt::file
