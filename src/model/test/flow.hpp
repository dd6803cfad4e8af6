// Documents for tests from YAML's flow style: {key: value, list: [a, "b"]}, with locations.
#pragma once

#include <string>
#include <string_view>

#include "takt/model/document.hpp"

namespace takt::model::test {

/// The node of a text; a value left out is null. Locations are in file `file`.
Node flow(std::string_view text, std::uint32_t file = 0);

/// `base` with the entries of `changes`: replaced, added, or taken out where the value is `~`.
Node changed(Node base, const Node& changes);

/// The parts of a test document: changes to a valid project.
struct Changes {
    std::string_view project = "{}";
    std::string_view line = "{}";
    std::string_view device = "{}";
    std::string_view variable = "{}";
    std::string_view local = "{}";
};

/// One serial line, one device, one int variable; locals go (bool), state (int), and L, which `local`
/// changes.
Document document(const Changes& changes);

}  // namespace takt::model::test
