// A located document: what stands in a project file, as raw text with its places, before anything is believed
// of it.
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

/// One node: nothing, a scalar, a list or a mapping. Scalars are kept as written: `0x10` and `010` are still
/// apart.
struct Node {
    enum class Kind : std::uint8_t { null, scalar, list, mapping };
    struct Entry;

    Kind kind = Kind::null;
    SourceLocation location;
    std::string text;            ///< a scalar's text, without quotes
    bool quoted = false;         ///< stood in quotes: text in YAML; in a table that says nothing
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

/// A whole project as it was read: the main file and the CSV tables it names (already put instead of the
/// `variables:` that named them, as a list of mappings with the places of the CSV cells).
struct Document {
    std::vector<std::string> files;  ///< names as the user gave them; files[0] is the project file
    Node root;
};

}  // namespace takt::model
