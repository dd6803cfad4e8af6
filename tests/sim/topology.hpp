// Random but legal projects, which the simulation runs when it is given none.
#pragma once

#include <cstdint>
#include <string>

#include "takt/base/result.hpp"
#include "takt/model/project.hpp"

namespace takt::simtest {

/// A project with its text, so that a run can be inspected and repeated by hand.
struct Topology {
    std::string text;
    model::Project project;
    std::string error;  ///< empty: it is legal, as it always ought to be
};

/// 1..3 lines of all framings with 1..10 devices, variables of every type and area, every strategy, triggers,
/// write on change, switches, statuses. Depends on the seed alone. The lines of most seeds hold their
/// periods; some are overloaded.
[[nodiscard]] Topology make_topology(std::uint64_t seed);

/// The project of a text or file; errors are in English, with their location.
struct ReadProject {
    model::Project project;
    std::string error;  ///< empty: there is none
};
[[nodiscard]] ReadProject read_text(const std::string& text);
[[nodiscard]] ReadProject read_file(const std::string& path);

}  // namespace takt::simtest
