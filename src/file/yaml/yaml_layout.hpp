// Where the nodes of a YAML text are, byte by byte, for changes in place.
//
// Nodes know where they begin, but not where they end. The layout is found by a second pass over the text
// that the nodes guide: it knows which token comes next, so it needs no grammar of its own. Forms that no
// project file uses (tags, anchors) are not laid out.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "takt/model/document.hpp"

namespace takt::file {

/// Plain scalars that mean null (YAML 1.2, section 10.3.2).
inline constexpr std::array<std::string_view, 4> kNullWords{"~", "null", "Null", "NULL"};

struct LayoutPart;

/// The place of one node. Offsets are bytes of the text.
struct Layout {
    enum class Style : std::uint8_t {
        absent,         ///< a null that is not written
        plain,          ///< also a null that is written
        single_quoted,  ///< 'text'
        double_quoted,  ///< "text"
        block_scalar,   ///< | or >
        flow,           ///< a list or mapping in brackets
        pair,           ///< a mapping of one key without brackets, in a flow list
        block,          ///< a list or mapping by indentation
    };

    const model::Node* node = nullptr;
    Style style = Style::absent;
    std::size_t begin = 0;
    std::size_t end = 0;     ///< behind the last character; of block collections behind their last line
    std::size_t column = 0;  ///< of the dashes or keys of a block collection, of a block scalar's text
    std::vector<LayoutPart> parts;  ///< items or entries, as in the node
};

/// An item of a list or an entry of a mapping.
struct LayoutPart {
    static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

    std::size_t begin = 0;          ///< of the dash, the key or its `?`; in a flow list of the value
    std::size_t indicator_end = 0;  ///< behind the dash or the colon
    /// In a block collection: behind its last line, which includes the comment there and comment lines below
    /// it that are indented more than it is. In a flow collection: behind the value.
    std::size_t end = 0;
    std::size_t comma = kNone;  ///< behind it, in a flow collection
    Layout value;
};

/// The layout of a text that was read as `root`, which must outlive it.
/// @returns nothing if the text has a form that cannot be laid out
[[nodiscard]] std::optional<Layout> lay_out(std::string_view text, const model::Node& root);

/// The beginning of the line of `offset`. A byte order mark belongs to no line.
[[nodiscard]] std::size_t line_begin(std::string_view text, std::size_t offset);
/// Behind the line break of the line of `offset`, or the end of the text.
[[nodiscard]] std::size_t line_end(std::string_view text, std::size_t offset);

}  // namespace takt::file
