// The keys that lines, servers and instruments share: a port or a host, and the format of characters.
#include "interpretation.hpp"

namespace takt::model {

bool report_tls(Reader& reader) {
    const Node* const node = reader.value("transport");
    if (node == nullptr || node->kind != Node::Kind::scalar || node->text != name(Transport::tls))
        return false;
    reader.report(Rule::line_tls, "transport", reader.allowed_text("transport"));
    return true;
}

bool report_missing_port(Reader& reader, std::string_view key, std::string_view transport) {
    if (reader.node().find(key) != nullptr || reader.misspelt(key)) return false;
    reader.report(Rule::line_port_missing, key, {},
                  {{"key", std::string(key)}, {"transport", std::string(transport)}});
    return true;
}

void register_port(Interpretation& state, Reader& reader, const std::string& port) {
    constexpr std::string_view kKey = "port";
    if (port.empty()) return;
    const auto [first, is_new] = state.ports.try_emplace(port, reader.value(kKey)->location);
    if (!is_new) reader.report(Rule::line_port_twice, kKey, {}, {{"first", state.describe(first->second)}});
}

void report_keys_without_effect(Reader& reader, std::span<const std::string_view> keys,
                                std::string_view transport) {
    for (const auto key : keys)
        if (reader.given(key)) reader.report_without_effect(key, "transport: " + std::string(transport));
}

wire::CharacterFormat read_character_format(Reader& reader, wire::Framing framing) {
    wire::CharacterFormat format;
    const auto baud = reader.integer("baud");
    const auto data_bits = reader.integer("data_bits");
    const auto stop_bits = reader.integer("stop_bits");
    if (baud) format.baud = static_cast<std::uint32_t>(*baud);
    format.data_bits = static_cast<std::uint8_t>(data_bits.value_or(framing == wire::Framing::ascii ? 7 : 8));
    format.parity = reader.choice<wire::Parity>("parity").value_or(format.parity);
    if (stop_bits) format.stop_bits = static_cast<std::uint8_t>(*stop_bits);
    return format;
}

}  // namespace takt::model
