// Changes the text of a project file so that it reads as another document, and touches nothing else.
//
// Comments, blank lines, the order of keys, indentation, line ends, quotes and a byte order mark of all that
// stays are kept byte by byte (docs/decisions/0044-editing-project-files.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <string>
#include <string_view>

#include "takt/file/load.hpp"
#include "takt/model/document.hpp"

namespace takt::file {

/// A key of the wanted document, in mappings inside lists: the index of the item in that list of the file
/// that this one comes from. Items without it are new. It is no part of the document.
inline constexpr std::string_view kOriginKey = "$from";

/// Keys of one mapping; more are refused.
inline constexpr std::size_t kMaxEditedKeys = 4096;

/// The project file alone, for changes: names of tables and templates stay scalars.
[[nodiscard]] Loaded read_project_text(const std::string& name, const std::string& text);

struct EditError {
    enum class Kind : std::uint8_t {
        unreadable,  ///< the text has findings, or no mapping
        layout,      ///< the text has a form that cannot be changed in place
        origin,      ///< an index of kOriginKey is out of range or used twice; subject: the path
        too_large,   ///< the document, or the new text, is beyond the limits of files
        differs,     ///< the new text would not read as the wanted document; subject: the path
    };
    Kind kind = Kind::differs;
    std::string subject = {};
    friend bool operator==(const EditError&, const EditError&) = default;
};

/// The text with the changes. Order: keys that are added take their place in the order of model::fields(), in
/// the style of their mapping; items that are added have the style of their neighbours. A key or item that is
/// removed takes the comment of its line along. Comment lines above it stay; comment lines directly above an
/// item that moves, move with it. New scalars have quotes only where they need them. The result was read
/// again and compared with `wanted`.
/// @param wanted  a mapping; the order of its keys, locations and Node::quoted have no meaning
[[nodiscard]] std::expected<std::string, EditError> patched_project(const std::string& text,
                                                                    const model::Node& wanted);

/// Whether two documents have the same contents: kinds, scalars, items in order, keys in any order.
/// kOriginKey is ignored.
[[nodiscard]] bool same_document(const model::Node& a, const model::Node& b);

}  // namespace takt::file
