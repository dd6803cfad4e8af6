// The keys that lines, servers and instruments share: a port or a host, and the format of characters.
#include <algorithm>
#include <charconv>
#include <system_error>
#include <utility>

#include "servers/interpretation.hpp"
#include "takt/base/ascii.hpp"
#include "takt/model/target_url.hpp"

namespace takt::model {
namespace {

/// Four numbers 0..255 with points between them.
bool is_ipv4(std::string_view text) {
    int parts = 0;
    for (std::size_t begin = 0; begin <= text.size(); ++parts) {
        const auto end = std::min(text.find('.', begin), text.size());
        const auto part = text.substr(begin, end - begin);
        int number = 256;
        const auto parsed = std::from_chars(part.data(), part.data() + part.size(), number);
        if (parsed.ec != std::errc() || parsed.ptr != part.data() + part.size() || number > 255) return false;
        begin = end + 1;
    }
    return parts == 4;
}

/// No character of a name, an address or a zone. A name may have letters of any language.
bool is_alien(char c) {
    constexpr std::string_view kOthers = ".-_:%";
    const bool letter =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || static_cast<unsigned char>(c) > 127;
    return !letter && !is_digit(c) && kOthers.find(c) == std::string_view::npos;
}

/// It is a server.
bool listens(const Reader& reader) {
    return find_field(reader.object(), "listen") != nullptr;
}

/// `port: 502`, meant as `tcp_port`, and `port: 10.0.0.1:502`, meant as `host`. False: it is neither.
bool report_network(Reader& reader, const std::string& port) {
    const std::string key(listens(reader) ? "listen" : "host");
    if (all_digits(port)) {
        reader.report(Rule::line_port_number, "port", {}, {{"port", port}, {"key", key}});
        return true;
    }
    const auto address = port_settings(port) ? std::nullopt : network_address(port);
    if (!address) return false;
    auto keys = std::string(port.starts_with("tls://") ? "transport: tls, " : "transport: tcp, ")
                    .append(key)
                    .append(": ")
                    .append(address->host);
    if (!address->tcp_port.empty()) keys.append(", tcp_port: ").append(address->tcp_port);
    if (address->rtu) keys.append(", framing: rtu");
    reader.report(Rule::line_port_settings, "port", {}, {{"keys", keys}});
    return true;
}

/// `port: "/dev/ttyUSB0,9600"`, `port: COM3`. False: it is no such port.
bool report_port_settings(Reader& reader, const std::string& port) {
    const auto meant = port_settings(port);
    if (!meant) return false;
    const auto com = com_number(meant->port);
    auto file = com > 0 ? "/dev/ttyUSB0" : meant->port.starts_with('/') ? meant->port : "/dev/" + meant->port;
    const auto settings = meant->joined(": ", ", ");
    Arguments arguments{{"keys", "port: " + std::move(file) + (settings.empty() ? "" : ", " + settings)}};
    if (com > 0)
        arguments.insert(arguments.end(),
                         {{"variant", "com"}, {"device", "/dev/ttyS" + std::to_string(com - 1)}});
    reader.report(Rule::line_port_settings, "port", {}, std::move(arguments));
    return true;
}

}  // namespace

bool report_tls(Reader& reader) {
    const Node* const node = reader.value("transport");
    if (node == nullptr || node->kind != Node::Kind::scalar || node->text != name(Transport::tls))
        return false;
    reader.report(Rule::line_tls, "transport", reader.allowed_text("transport"));
    return true;
}

TlsFiles read_tls(Interpretation& state, Reader& reader, Transport transport, std::string_view own) {
    const auto& project = state.document.files.empty() ? std::string() : state.document.files.front();
    const auto folder = project.substr(0, project.rfind('/') + 1);
    const auto beside = [&](const std::string& file) { return file.starts_with('/') ? file : folder + file; };
    TlsFiles files = files_in(folder + std::string(kCertificateFolder), own);
    const Node* const given = reader.mapping("tls");
    const bool used = transport == Transport::tls;
    if (!used) reader.report_needs("tls", "transport: tls");
    if (given == nullptr) return used ? files : TlsFiles{};
    Reader keys(state.findings, *given, reader.path_of("tls"), Object::tls, state.context);
    if (const auto file = keys.text("ca")) files.ca = beside(*file);
    if (const auto file = keys.text("certificate")) files.certificate = beside(*file);
    if (const auto file = keys.text("key")) files.key = beside(*file);
    if (const auto file = keys.text("crl")) files.crl = beside(*file);
    files.server_name = keys.text("server_name").value_or("");
    if (!files.server_name.empty()) check_host(keys, "server_name", files.server_name);
    if (listens(reader)) keys.report_needs("server_name", "lines");
    return used ? files : TlsFiles{};
}

bool report_missing_port(Reader& reader, std::string_view key, std::string_view transport) {
    if (reader.node().find(key) != nullptr || reader.misspelt(key)) return false;
    Arguments arguments{{"key", std::string(key)}, {"transport", std::string(transport)}};
    if (listens(reader)) arguments.emplace_back("variant", "listen");
    reader.report(Rule::line_port_missing, key, {}, std::move(arguments));
    return true;
}

bool names_host(const Reader& reader) {
    const Node* const port = reader.value("port");
    return (reader.given("host") || reader.misspelt("host")) && (port == nullptr || all_digits(port->text));
}

bool check_host(Reader& reader, std::string_view key, std::string_view host) {
    const auto is_of = [](std::string_view text, std::string_view characters) {
        return !text.empty() && text.find_first_not_of(characters) == std::string_view::npos;
    };
    const auto colon = host.find(':');
    const bool one_colon =
        colon != std::string_view::npos && host.find(':', colon + 1) == std::string_view::npos;
    if (key == "listen" && host == "*") return true;
    if (one_colon && is_of(host.substr(colon + 1), "0123456789")) {
        reader.report(Rule::host_with_port, key, {},
                      {{"key", std::string(key)},
                       {"host", std::string(host.substr(0, colon))},
                       {"port", std::string(host.substr(colon + 1))}});
    } else if (is_of(host, "0123456789.") && !is_ipv4(host)) {
        reader.report(Rule::host_no_address, key);
    } else if (std::ranges::any_of(host, is_alien)) {
        reader.report(Rule::host_malformed, key);
    } else {
        return true;
    }
    return false;
}

void register_port(Interpretation& state, Reader& reader, const std::string& port) {
    constexpr std::string_view kKey = "port";
    if (port.empty() || report_network(reader, port) || report_port_settings(reader, port)) return;
    const auto [first, is_new] = state.ports.try_emplace(port, reader, kKey);
    if (!is_new) reader.report(Rule::line_port_twice, kKey, {}, {{"first", state.describe(first->second)}});
}

void report_keys_without_effect(Reader& reader, std::span<const std::string_view> keys,
                                std::string_view transport) {
    for (const auto key : keys)
        if (reader.given(key) && (key != "port" || !report_network(reader, reader.value(key)->text)))
            reader.report_without_effect(key, "transport: " + std::string(transport));
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
