// Builds the nodes of documents and of the rows of tables.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "takt/model/document.hpp"

namespace takt::file {

model::Node scalar(std::string_view text, const model::SourceLocation& location = {});

/// An empty list or mapping.
model::Node collection(model::Node::Kind kind, const model::SourceLocation& location = {});

/// The value of a key in a mapping; nullptr if there is none. It is valid until the mapping changes.
model::Node* find_value(model::Node& mapping, std::string_view key);

/// Sets the value of a key in a mapping.
void set(model::Node& mapping, std::string_view key, model::Node value);

/// A list of one item.
model::Node list_of(model::Node item);

/// A mapping of scalars.
model::Node mapping_of(const std::vector<std::pair<std::string, std::string>>& settings,
                       const model::SourceLocation& location = {});

/// The text of a key in a mapping; empty if there is none.
std::string text_of(const model::Node& row, std::string_view key);

/// Whether the key is that of a column of the line or the device.
bool names_place(std::string_view key);

/// A row without the columns of the line and the device.
model::Node without_place(const model::Node& row);

}  // namespace takt::file
