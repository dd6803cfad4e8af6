// The parts of a project that are in other files than the project file.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "takt/file/json.hpp"
#include "takt/model/document.hpp"
#include "takt/model/findings.hpp"

namespace takt::web {

/// [{"path", "file", "rows"}]: the tables and device templates that a project names. `rows` are the mappings
/// that they give the list there.
/// @param alone     the root of the project file
/// @param complete  the same with what other files contain
[[nodiscard]] file::Json read_only_parts(const model::Node& alone, const model::Node& complete,
                                         const std::string& project_file);

/// The variables that templates put before those of their device.
class TemplateParts {
public:
    TemplateParts(const model::Node& alone, const model::Node& complete);

    /// Gives findings the paths of the project file: those of a template's variables become paths of
    /// `device_template`.
    void correct(std::vector<model::Finding>& findings) const;

private:
    std::vector<std::pair<std::string, std::size_t>> counts_;  // by "lines[0].devices[2]"
};

}  // namespace takt::web
