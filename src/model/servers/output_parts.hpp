// The parts of the interpretation of an output.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "reading/reader.hpp"
#include "takt/model/output.hpp"

namespace takt::model {

struct Interpretation;

/// Whether a host is this computer itself.
[[nodiscard]] bool is_this_computer(std::string_view host);

/// `brokers`.
[[nodiscard]] std::vector<Broker> read_brokers(Interpretation& state, Reader& reader);

/// The topic behind a key; reports any other text.
/// @param allowed  its placeholders
[[nodiscard]] std::optional<TopicTemplate> read_topic(Reader& reader, std::string_view key,
                                                      std::span<const TopicPart> allowed);

/// The keys of selections: fills `selections` and `values`. Needs name and transport.
void read_selections(Interpretation& state, Reader& reader, Output& output);

/// Warns of a journal that an outage of a day fills. Needs `values`.
void check_quota(const Interpretation& state, Reader& reader, const Output& output);

/// Reports arrays of retained topics, and more messages than the window takes. Needs `values`.
void check_window(const Interpretation& state, Reader& reader, const Output& output);

/// `commands`: fills `commandable`.
void read_commands(Interpretation& state, Reader& reader, Output& output);

}  // namespace takt::model
