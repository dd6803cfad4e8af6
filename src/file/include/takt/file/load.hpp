// Loads a project: the YAML file and the CSV tables that it names become one located document.
//
// Only the structure is interpreted. Scalars stay as written. `variables: boiler.csv` of a device is replaced
// by the rows of that table; its path is relative to the project file (see table.hpp). `device_template:
// meter.yaml` is replaced by the keys and variables of that template (docs/device-templates.md). Anchors and
// aliases, tags, merge keys, duplicate keys and further documents are refused.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/model/document.hpp"
#include "takt/model/findings.hpp"

namespace takt::file {

/// Limits of a project; exceeding one is a finding.
inline constexpr std::size_t kMaxFileBytes = 8 << 20;      ///< each file
inline constexpr std::string_view kMaxFileText = "8 MiB";  ///< kMaxFileBytes in messages
inline constexpr std::size_t kMaxTableBytes = 64 << 20;    ///< all tables and templates of a project together
inline constexpr std::size_t kMaxNodes =
    1'000'000;                                    ///< keys, values, lists and mappings in all files together
inline constexpr std::size_t kMaxDepth = 32;      ///< lists and mappings inside one another
inline constexpr std::size_t kMaxFindings = 200;  ///< the last one then reports that there are more

/// A loaded project. Codes of findings begin with "file."; every location has its file. Order: file, line,
/// column. Only tables cause warnings.
struct Loaded {
    model::Document document;
    std::vector<model::Finding> findings;
    /// The document is complete, except at the locations in the findings, and may be interpreted. If false it
    /// is empty: the project file cannot be read or is no YAML document.
    bool readable = false;
};

/// Loads the project file `path`. Never throws, and never blocks, also on a pipe or a device.
[[nodiscard]] Loaded load_project(const std::string& path);

/// Gives load_text() the tables that a project names: the bytes of a path, at most kMaxFileBytes.
using Reader = std::function<Result<std::string>(const std::string& path)>;

/// The same from a text. `name` is its entry in Document::files and the base of relative paths. Without a
/// reader no table is found.
[[nodiscard]] Loaded load_text(const std::string& name, const std::string& text, const Reader& reader = {});

/// The same from the root of a project file that was read already, or never was a text.
[[nodiscard]] Loaded load_document(const std::string& name, model::Node root, const Reader& reader = {});

/// Reads from the file system.
[[nodiscard]] Reader file_reader();

}  // namespace takt::file
