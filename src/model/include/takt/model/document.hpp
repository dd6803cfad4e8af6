// The located document: the raw text of a project file with source locations, before any interpretation.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace takt::model {

/// A location in one of a document's files. Line and column count from 1; line 0: the file as a whole.
struct SourceLocation {
    std::uint32_t file = 0;  ///< index into Document::files
    std::uint32_t line = 0;
    std::uint32_t column = 0;
    friend bool operator==(const SourceLocation&, const SourceLocation&) = default;
};

/// A node: null, scalar, list or mapping. Scalars stay as written, so `0x10` and `16` differ.
struct Node {
    enum class Kind : std::uint8_t { null, scalar, list, mapping };
    struct Entry;

    Kind kind = Kind::null;
    SourceLocation location;
    std::string text;            ///< a scalar's text, without quotes
    bool quoted = false;         ///< in quotes: always text in YAML; without meaning in a table
    bool cell = false;           ///< of a table, or the heading of a column
    std::vector<Node> items;     ///< of a list
    std::vector<Entry> entries;  ///< of a mapping: in file order, keys unique

    /// The value of `key` in a mapping, or nullptr.
    [[nodiscard]] const Node* find(std::string_view key) const;
};

/// Key (a scalar) and value.
struct Node::Entry {
    Node key;
    Node value;
};

/// A whole project as read: the main file, and each CSV table in place of the `variables:` that named it, as
/// a list of mappings with the locations of the cells.
struct Document {
    std::vector<std::string> files;  ///< names as the user gave them; files[0] is the project file
    Node root;
};

}  // namespace takt::model
