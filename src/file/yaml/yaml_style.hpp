// The style of a YAML text, and new nodes in that style.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/model/document.hpp"
#include "takt/model/fields.hpp"
#include "yaml/yaml_layout.hpp"

namespace takt::file {

struct YamlStyle {
    std::string line_break = "\n";
    std::size_t list_indent = 2;                ///< from a key to the dashes of its list
    std::size_t mapping_indent = 2;             ///< from a key to the keys of its mapping
    bool padded = false;                        ///< `{ a: 1 }`
    std::map<model::Object, bool> block_items;  ///< items of that kind are block mappings
};

/// The style of a file: that of the first example of each form.
[[nodiscard]] YamlStyle style_of(std::string_view text, const Layout& root);

/// Writes nodes that are not in the file yet. kOriginKey is left out.
class YamlWriter {
public:
    explicit YamlWriter(const YamlStyle& style) : style_(style) {}

    /// `key: value` inside brackets.
    [[nodiscard]] std::string flow_entry(const model::Node& owner, const model::Node::Entry& entry,
                                         std::optional<model::Object> object) const;
    /// An item of a flow list.
    [[nodiscard]] std::string flow_item(const model::Node& item, std::optional<model::Object> object) const;

    /// `key: value` with its line break, without the indentation of its first line.
    [[nodiscard]] std::string block_entry(const model::Node& owner, const model::Node::Entry& entry,
                                          std::optional<model::Object> object, std::size_t column) const;
    /// `- item` with its line break, without the indentation of its first line.
    /// @param block  a mapping is written by indentation
    /// @param gap    from the dash to the item
    [[nodiscard]] std::string block_item(const model::Node& item, std::optional<model::Object> object,
                                         std::size_t column, bool block, std::size_t gap = 2) const;

    /// Whether a new value is written by indentation.
    [[nodiscard]] bool needs_lines(const model::Node& value) const;
    /// The lines of such a value below a key at `column`.
    [[nodiscard]] std::string lines(const model::Node& value, std::optional<model::Object> object,
                                    std::size_t column) const;
    /// The value behind a key, in one line.
    [[nodiscard]] std::string value_text(const model::Node& owner, const model::Node::Entry& entry,
                                         std::optional<model::Object> object, bool flow) const;
    /// Whether items of that kind are written by indentation.
    [[nodiscard]] bool is_block_item(const model::Node& item, std::optional<model::Object> object) const;

private:
    [[nodiscard]] std::string flow_mapping(const model::Node& node,
                                           std::optional<model::Object> object) const;
    [[nodiscard]] std::string flow_list(const model::Node& node, std::optional<model::Object> object) const;

    const YamlStyle& style_;
};

/// The entries of a mapping in the order of the field table; unknown keys last. Without kOriginKey.
[[nodiscard]] std::vector<const model::Node::Entry*> ordered_entries(const model::Node& mapping,
                                                                     std::optional<model::Object> object);

inline constexpr std::size_t kNoRank = static_cast<std::size_t>(-1);

/// The place of a key in the field table; kNoRank: it is unknown.
[[nodiscard]] std::size_t rank_of(std::optional<model::Object> object, std::string_view key);

}  // namespace takt::file
