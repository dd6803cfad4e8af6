// The lines, devices and servers that two projects have in common, at any index.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "takt/model/project.hpp"

namespace takt::model {

/// By index in the newer project: the index of the same thing in the older one; nothing: it is new or
/// changed.
using Continued = std::vector<std::optional<std::size_t>>;

/// Instruments with the same settings.
[[nodiscard]] Continued continued_instruments(const Project& before, const Project& now);

/// Lines with the same name and framing, as far as a gateway can distinguish them: their port, devices and
/// timing may differ.
[[nodiscard]] Continued continued_gateways(const Project& before, const Project& now);

/// Servers that a client cannot distinguish: the same settings, units and sources, relays to lines that
/// continued_gateways() has and values of instruments that continued_instruments() has. Access rules may
/// differ.
[[nodiscard]] Continued continued_servers(const Project& before, const Project& now);

}  // namespace takt::model
