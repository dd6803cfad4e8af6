#include "takt/model/target_url.hpp"

#include <algorithm>
#include <charconv>
#include <span>

#include "takt/base/ascii.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/synonyms.hpp"

namespace takt::model {
namespace {

bool is_network(const Line& line) {
    return is_network(line.transport);
}

char parity_letter(wire::Parity parity) {
    return parity == wire::Parity::none ? 'N' : parity == wire::Parity::even ? 'E' : 'O';
}

/// A device file, or its name: "ttyUSB0", "COM3".
bool is_port(std::string_view text) {
    return (text.size() > 1 && text[0] == '/') || (text.size() > 3 && text.starts_with("tty")) ||
           com_number(text) > 0;
}

constexpr std::string_view kSeparators = ",;?&@: ";

/// Appends the settings of one part: "parity=E", "9600", "8E1", "E", "8". False: it has no known meaning.
bool take_part(PortSettings& taken, std::string_view part) {
    auto& settings = taken.settings;
    const auto meant_parity = [](std::string_view text) { return value_synonym("parity", kParities, text); };
    if (const auto equals = part.find('='); equals != std::string_view::npos) {
        const auto* const key = std::ranges::find(kPortKeys, part.substr(0, equals));
        if (key == kPortKeys.end()) return false;
        const auto value = part.substr(equals + 1);
        const auto meant = *key == "parity" ? meant_parity(value) : std::string_view();
        settings.emplace_back(*key, meant.empty() ? value : meant);
        return true;
    }
    if (all_digits(part) && part.size() > 2) {
        settings.emplace_back("baud", part);
        return true;
    }
    const auto take_bits = [&](std::string_view key, char bits, char least) {
        if (bits < least || bits > least + 1) return false;
        settings.emplace_back(key, std::string(1, bits));
        return true;
    };
    const auto take_parity = [&](std::string_view letter) {
        const auto meant = meant_parity(letter);
        if (!meant.empty()) settings.emplace_back("parity", meant);
        return !meant.empty();
    };
    if (part.size() == 1)
        return take_parity(part) || take_bits("data_bits", part[0], '7') ||
               take_bits("stop_bits", part[0], '1');
    return part.size() == 3 && take_bits("data_bits", part[0], '7') && take_parity(part.substr(1, 1)) &&
           take_bits("stop_bits", part[2], '1');
}

/// The settings behind the port, which are parts with separators between them.
bool take_parts(PortSettings& taken, std::string_view parts) {
    while (!parts.empty()) {
        const auto end = std::min(parts.find_first_of(kSeparators), parts.size());
        if (end > 0 && !take_part(taken, parts.substr(0, end))) return false;
        parts.remove_prefix(std::min(end + 1, parts.size()));
    }
    return true;
}

}  // namespace

std::string_view scheme_of(const Line& line) {
    if (line.transport == Transport::tls) return "tls";
    if (line.transport == Transport::tcp) return line.framing == wire::Framing::rtu ? "rtu+tcp" : "tcp";
    return line.framing == wire::Framing::ascii ? "ascii" : "rtu";
}

std::string host_and_port(std::string_view host, std::uint16_t port) {
    const bool ipv6 = host.find(':') != std::string_view::npos;
    std::string text = ipv6 ? std::string("[").append(host).append("]") : std::string(host);
    return text.append(":").append(std::to_string(port));
}

std::string url_of(const Line& line) {
    auto url = std::string(scheme_of(line)).append("://");
    if (is_network(line)) {
        url.append(host_and_port(line.port, line.tcp_port));
        const auto folder = line.tls.ca.substr(0, line.tls.ca.rfind('/') + 1);
        const bool named = line.transport == Transport::tls && folder != kCertificateFolder;
        return named && files_in(folder, "client") == line.tls ? url.append("?certs=").append(folder) : url;
    }
    const auto& format = line.format;
    url.append(line.port).append("?baud=").append(std::to_string(format.baud));
    url.append("&parity=").append(kParities[static_cast<std::size_t>(format.parity)]);
    url.append("&stop_bits=").append(std::to_string(format.stop_bits));
    if (line.framing == wire::Framing::ascii)
        url.append("&data_bits=").append(std::to_string(format.data_bits));
    if (line.rs485 != Rs485::automatic)
        url.append("&rs485=").append(kRs485[static_cast<std::size_t>(line.rs485)]);
    return url;
}

std::string settings_text(const Line& line) {
    if (is_network(line)) return {};
    const auto& format = line.format;
    auto text = std::to_string(format.baud).append(" ").append(std::to_string(format.data_bits));
    text.push_back(parity_letter(format.parity));
    return text.append(std::to_string(format.stop_bits));
}

std::string PortSettings::joined(std::string_view equals, std::string_view separator) const {
    std::string text;
    for (const auto& [key, value] : settings)
        text.append(text.empty() ? "" : separator).append(key).append(equals).append(value);
    return text;
}

unsigned com_number(std::string_view text) {
    constexpr std::string_view kCom = "com";
    unsigned number = 0;
    if (text.size() <= kCom.size() || !std::ranges::equal(text.substr(0, kCom.size()), kCom, {}, lower_case))
        return 0;
    const auto* const end = text.data() + text.size();
    const auto read = std::from_chars(text.data() + kCom.size(), end, number);
    return read.ec == std::errc() && read.ptr == end ? number : 0;
}

std::optional<NetworkAddress> network_address(std::string_view text) {
    NetworkAddress found;
    const auto colon = text.find("://");
    const auto scheme = colon == std::string_view::npos ? std::string_view() : text.substr(0, colon);
    if (!scheme.empty()) text.remove_prefix(colon + 3);
    found.rtu = scheme.starts_with("rtu");
    text = text.substr(0, text.find_first_of("/?#"));
    found.host = text.substr(0, text.starts_with('[') ? text.find(']') : text.find(':'));
    if (text.starts_with('[')) found.host.remove_prefix(1);
    const auto port = text.rfind(':');
    const bool with_port = port != std::string_view::npos && all_digits(text.substr(port + 1));
    if (with_port) found.tcp_port = text.substr(port + 1);
    const bool numbers =
        found.host.contains('.') && found.host.find_first_not_of("0123456789.") == std::string_view::npos;
    const bool network = scheme.ends_with("tcp") || scheme == "tls";
    if (found.host.empty() || !(with_port || numbers || network)) return std::nullopt;
    return found;
}

std::optional<PortSettings> port_settings(std::string_view text) {
    bool scheme = false;
    for (const std::string_view prefix : {"rtu://", "ascii://"})
        if (text.starts_with(prefix)) {
            scheme = true;
            text.remove_prefix(prefix.size());
        }
    if (text.find("://") != std::string_view::npos) return std::nullopt;
    // The port may have separators of its own: "/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0".
    for (std::size_t at = 0; at <= text.size(); ++at) {
        if (at < text.size() && kSeparators.find(text[at]) == std::string_view::npos) continue;
        PortSettings taken{.port = std::string(text.substr(0, at)), .settings = {}};
        if (!take_parts(taken, text.substr(at))) continue;
        const bool only_port = !scheme && taken.settings.empty() && taken.port.starts_with('/');
        const bool found = !only_port && is_port(taken.port);
        return found ? std::optional(std::move(taken)) : std::nullopt;
    }
    return std::nullopt;
}

}  // namespace takt::model
