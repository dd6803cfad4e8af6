// A fast reader for the common part of YAML. yaml-cpp reads everything else.
#pragma once

#include <cstddef>
#include <optional>

#include "source.hpp"
#include "yaml_builder.hpp"

namespace takt::file {

/// Reads a document that has only the following. The result is exactly that of yaml-cpp, at a tenth of its
/// time.
///   - block mappings and lists, also without further indentation below a key (`a:` and `- b` below it)
///   - keys of letters, digits, `_`, `-`, `.` and `/`, with their colon
///   - plain texts of one line; texts in quotes, of one line and without escape sequences
///   - flow mappings and lists. They may go on in the next line after `,`, `[` and `{`
///   - comments
/// Errors of the builder other than Stop are reported as usual.
/// @returns false if the text has anything else, or the builder stopped. Then the builder is incomplete, and
/// its findings are void
[[nodiscard]] bool read_plain_yaml(const Source& source, YamlBuilder& builder);

}  // namespace takt::file
