// Reading a project: the YAML file and the CSV tables it names become one located document.
//
// Nothing is interpreted here but the structure: scalars stay as they are written, `variables: boiler.csv` of
// a device is replaced by the rows of that table (its path is relative to the project file; table.hpp tells
// what is understood there), and what YAML
// allows beyond plain mappings, lists and scalars (anchors and aliases, tags, merge keys, duplicate keys,
// further documents) is refused.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/model/document.hpp"
#include "takt/model/findings.hpp"

namespace takt::file {

/// Bounds on a project; beyond them is a finding.
inline constexpr std::size_t kMaxFileBytes = 8 << 20;    ///< each file
inline constexpr std::size_t kMaxTableBytes = 64 << 20;  ///< all tables of a project together
inline constexpr std::size_t kMaxNodes =
    1'000'000;                                    ///< keys, values, lists and mappings in all files together
inline constexpr std::size_t kMaxDepth = 32;      ///< lists and mappings inside one another
inline constexpr std::size_t kMaxFindings = 200;  ///< the last of which then says that there are more

/// What was read. Codes of findings begin with "file." and their location is never without its file; they
/// stand in the order of file, line, column. Warnings are only about tables.
struct Loaded {
    model::Document document;
    std::vector<model::Finding> findings;
    /// The document is whole, up to the places in the findings, and may be interpreted. Else it is empty: the
    /// project file cannot be read or is not a YAML document.
    bool readable = false;
};

/// Loads the project file `path`. Never throws, never waits, whatever the path names.
[[nodiscard]] Loaded load_project(const std::string& path);

/// How load_text() gets at the tables a project names: the bytes of a path, at most kMaxFileBytes.
using Reader = std::function<Result<std::string>(const std::string& path)>;

/// The same from a text. `name` stands in Document::files and tables are relative to it; without a reader
/// they are not found.
[[nodiscard]] Loaded load_text(const std::string& name, const std::string& text, const Reader& reader = {});

}  // namespace takt::file
