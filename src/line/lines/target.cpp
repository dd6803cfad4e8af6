#include "takt/line/target.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <span>
#include <utility>

#include "takt/base/ascii.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/synonyms.hpp"
#include "takt/model/target_url.hpp"

namespace takt::line {
namespace {

struct Scheme {
    std::string_view name;
    model::Transport transport;
    wire::Framing framing;
    std::uint16_t tcp_port;
};
constexpr std::uint16_t kTlsPort = 802;
constexpr std::array kSchemes{
    Scheme{"tcp", model::Transport::tcp, wire::Framing::tcp, 502},
    Scheme{"tls", model::Transport::tls, wire::Framing::tcp, kTlsPort},
    Scheme{"rtu+tcp", model::Transport::tcp, wire::Framing::rtu, 502},
    Scheme{"rtu", model::Transport::serial, wire::Framing::rtu, 0},
    Scheme{"ascii", model::Transport::serial, wire::Framing::ascii, 0},
};
constexpr std::array<std::string_view, 5> kSchemeNames{"tcp", "tls", "rtu+tcp", "rtu", "ascii"};
constexpr std::string_view kPort = "/dev/ttyUSB0";

std::unexpected<Error> wrong(std::string_view part, std::string_view right = {}) {
    constexpr std::size_t kShown = 60;
    std::string subject(part.substr(0, kShown));
    if (part.size() > kShown) subject += "…";
    if (!right.empty()) subject.append(" → ").append(right);
    return fail(Code::syntax, subject);
}

std::string list(std::span<const std::string_view> words) {
    std::string text;
    for (const auto word : words) text.append(text.empty() ? "" : ", ").append(word);
    return text;
}

// `value`, one part of "rtu+tpc://plc" or "parity=evn", is not one of `words`.
// @param key  of the value; empty: it is a key itself, or a scheme
std::unexpected<Error> wrong_word(std::string_view before, std::string_view value, std::string_view after,
                                  std::string_view key, std::span<const std::string_view> words) {
    const auto whole = [&](std::string_view word) { return std::string(before).append(word).append(after); };
    const auto meant = model::meant_word(key, words, value);
    return wrong(whole(value), meant.empty() ? list(words) : whole(meant));
}

// "?baud=9600&parity=even"; empty without settings.
std::string query_of(const model::PortSettings& meant) {
    return (meant.settings.empty() ? "" : "?") + meant.joined("=", "&");
}

// The serial port that a name without a folder means.
std::string port_of(std::string_view scheme, std::string_view name, const std::string& query = {}) {
    const auto com = model::com_number(name);
    if (com == 0) return std::string(scheme).append("/dev/").append(name).append(query);
    const auto second = std::string(scheme).append("/dev/ttyS").append(std::to_string(com - 1)).append(query);
    return std::string(scheme).append(kPort).append(query).append(", ").append(second);
}

Result<std::uint32_t> parse_number(std::string_view name, std::string_view text, std::uint32_t least,
                                   std::uint32_t greatest) {
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool digits =
        !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
    if (!digits || end != text.data() + text.size() || error != std::errc{})
        return wrong(std::string(name).append("=").append(text),
                     std::to_string(least) + ".." + std::to_string(greatest));
    if (value < least || value > greatest) return fail(Code::out_of_range, name, value, least, greatest);
    return static_cast<std::uint32_t>(value);
}

bool is_ipv6(std::string_view text) {
    in6_addr address{};
    return inet_pton(AF_INET6, std::string(text.substr(0, text.find('%'))).c_str(), &address) == 1;
}

bool is_host(std::string_view text) {
    constexpr std::size_t kLongest = 253;
    return !text.empty() && text.size() <= kLongest && std::ranges::all_of(text, [](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' ||
               c == '-' || c == '_';
    });
}

struct HostPort {
    std::string_view host;
    std::optional<std::uint16_t> port;
};

// host, host:port, [ipv6], [ipv6]:port; the host may be empty.
Result<HostPort> split_host_port(std::string_view text, std::uint32_t least_port) {
    HostPort address;
    std::string_view rest;
    if (text.starts_with('[')) {
        const auto close = text.find(']');
        if (close == std::string_view::npos || !is_ipv6(text.substr(1, close - 1)))
            return wrong(text, "[::1]:502");
        address.host = text.substr(1, close - 1);
        rest = text.substr(close + 1);
    } else {
        if (is_ipv6(text)) return wrong(text, std::string("[").append(text).append("]"));
        const auto colon = std::min(text.find(':'), text.size());
        address.host = text.substr(0, colon);
        rest = text.substr(colon);
    }
    if (rest.empty()) return address;
    if (!rest.starts_with(':')) return wrong(rest, ":502");
    TAKT_TRY(const auto port, parse_number("port", rest.substr(1), least_port, 65535));
    address.port = static_cast<std::uint16_t>(port);
    return address;
}

Result<void> apply_parameter(Target& target, std::string_view key, std::string_view value) {
    const bool rtu = target.framing == wire::Framing::rtu;
    if (key == "baud") {
        TAKT_TRY(target.format.baud, parse_number(key, value, 50, 4'000'000));
    } else if (key == "stop_bits") {
        TAKT_TRY(const auto bits, parse_number(key, value, 1, 2));
        target.format.stop_bits = static_cast<std::uint8_t>(bits);
    } else if (key == "data_bits") {
        TAKT_TRY(const auto bits, parse_number(key, value, rtu ? 8 : 7, 8));
        target.format.data_bits = static_cast<std::uint8_t>(bits);
    } else if (key == "parity") {
        const auto word = std::ranges::find(model::kParities, value);
        if (word == model::kParities.end()) return wrong_word("parity=", value, {}, key, model::kParities);
        target.format.parity = static_cast<wire::Parity>(word - model::kParities.begin());
    } else if (key == "rs485") {
        const auto word = std::ranges::find(model::kRs485, value);
        if (word == model::kRs485.end()) return wrong_word("rs485=", value, {}, key, model::kRs485);
        target.rs485 = static_cast<model::Rs485>(word - model::kRs485.begin());
    } else if (key == "unit") {
        return wrong(std::string("unit=").append(value), std::string("--unit ").append(value));
    } else {
        return wrong_word({}, key, std::string("=").append(value), {}, model::kPortKeys);
    }
    return {};
}

Result<Target> parse_serial_target(Target target, std::string_view rest) {
    const auto question = std::min(rest.find('?'), rest.size());
    const auto path = rest.substr(0, question);
    auto query = rest.substr(question);
    const std::string scheme = target.framing == wire::Framing::rtu ? "rtu://" : "ascii://";
    if (path.empty()) return wrong(scheme, scheme + std::string(kPort));
    const auto meant = model::port_settings(path);
    if (path.starts_with("dev/")) return wrong(path, scheme + "/" + std::string(path).append(query));
    if (!meant && target.framing == wire::Framing::rtu && model::network_address(path))
        return wrong(scheme + std::string(path), "rtu+tcp://" + std::string(path));
    if (!path.starts_with('/'))
        return wrong(path, meant ? port_of(scheme, meant->port, query_of(*meant)) : port_of(scheme, path));
    if (meant) return wrong(path.substr(meant->port.size()), scheme + meant->port + query_of(*meant));
    if (path.find('\0') != std::string_view::npos) return wrong(path);
    target.port = path;
    target.format.data_bits = target.framing == wire::Framing::ascii ? 7 : 8;

    if (!query.empty()) query.remove_prefix(1);
    while (!query.empty()) {
        const auto end = std::min(query.find('&'), query.size());
        const auto parameter = query.substr(0, end);
        query.remove_prefix(std::min(end + 1, query.size()));
        const auto equals = parameter.find('=');
        if (equals == std::string_view::npos) {
            const auto whole = model::port_settings(rest);
            return wrong(parameter, whole ? scheme + whole->port + query_of(*whole) : list(model::kPortKeys));
        }
        TAKT_CHECK(apply_parameter(target, parameter.substr(0, equals), parameter.substr(equals + 1)));
    }
    return target;
}

// Takes "?certs=FOLDER" from the end of a TLS address. @returns the folder with a slash at its end
std::string take_certificates(std::string_view& address) {
    constexpr std::string_view kKey = "?certs=";
    const auto begin = address.find(kKey);
    if (begin == std::string_view::npos) return std::string(model::kCertificateFolder);
    std::string folder(address.substr(begin + kKey.size()));
    address = address.substr(0, begin);
    if (!folder.empty() && !folder.ends_with('/')) folder += '/';
    return folder;
}

Result<Target> parse_network_target(Target target, std::string_view scheme, std::string_view rest) {
    target.format.baud = 0;
    if (rest.starts_with("/dev/")) return wrong(rest, std::string("rtu://").append(rest));
    if (target.transport == model::Transport::tls) target.certificates = take_certificates(rest);
    if (rest.ends_with('/')) rest.remove_suffix(1);
    const auto beyond = rest.find_first_of("/?#@");
    if (beyond != std::string_view::npos) {
        const auto part = rest.substr(beyond);
        const auto host = part[0] == '@' || beyond == 0 ? part.substr(1) : rest.substr(0, beyond);
        auto right = std::string(scheme).append("://").append(host.empty() ? "host:502" : host);
        constexpr std::string_view kUnit = "?unit=";
        if (part.starts_with(kUnit)) right.append(" --unit ").append(part.substr(kUnit.size()));
        return wrong(part, right);
    }
    TAKT_TRY(const HostPort address, split_host_port(rest, 1));
    if (!is_host(address.host) && !is_ipv6(address.host)) return wrong(rest, "host:502");
    target.port = address.host;
    if (address.port) target.tcp_port = *address.port;
    return target;
}

std::string suggestion(std::string_view text);

// The target that "tcp//plc", "tcp:/plc" or "rtu:/dev/ttyUSB0" means; empty: there is no scheme.
std::string with_scheme(std::string_view text) {
    for (const auto& scheme : kSchemes) {
        if (!text.starts_with(scheme.name)) continue;
        const auto rest = text.substr(scheme.name.size());
        const auto begin = std::min(rest.find_first_not_of(":;/\\"), rest.size());
        if (begin == 0) continue;
        const auto name = rest.substr(begin);
        if (scheme.transport != model::Transport::serial)
            return std::string(scheme.name).append(all_digits(name) ? "://host:" : "://").append(name);
        if (all_digits(name))
            return std::string(scheme.name).append("://").append(kPort).append("?baud=").append(name);
        if (scheme.framing == wire::Framing::rtu && model::network_address(name) &&
            !model::port_settings(name))
            return std::string("rtu+tcp://").append(name);
        const auto port = suggestion(rest.substr(rest[begin - 1] == '/' ? begin - 1 : begin));
        if (port.starts_with("rtu://")) return std::string(scheme.name).append(port.substr(3));
    }
    return {};
}

// The probable meaning of a text without "://".
std::string suggestion(std::string_view text) {
    if (auto meant = with_scheme(text); !meant.empty()) return meant;
    const bool only_settings = text.find('=') < text.find('/');
    const auto settings =
        model::port_settings(only_settings ? std::string(kPort).append("?").append(text) : std::string(text));
    const auto query = settings ? query_of(*settings) : std::string();
    if (settings) text = settings->port;
    if (text.starts_with('/')) return std::string("rtu://").append(text).append(query);
    if (text.starts_with("dev/")) return std::string("rtu:///").append(text);
    if (text.starts_with("tty") || model::com_number(text) > 0) return port_of("rtu://", text, query);
    const auto address = split_host_port(text, 1);
    if (address && is_host(address->host)) return std::string("tcp://").append(text);
    if (is_ipv6(text)) return std::string("tcp://[").append(text).append("]");
    if (address && is_ipv6(address->host)) return std::string("tcp://").append(text);
    return std::string("tcp://host:502, rtu:///dev/ttyUSB0");
}

}  // namespace

model::Line Target::as_line() const {
    model::Line line;
    line.name = transport == model::Transport::serial ? port : host_and_port(port, tcp_port);
    line.transport = transport;
    line.port = port;
    line.tcp_port = tcp_port;
    line.framing = framing;
    line.format = format;
    line.rs485 = rs485;
    if (transport == model::Transport::tls) line.tls = model::files_in(certificates, "client");
    return line;
}

Result<Target> parse_target(std::string_view url) {
    const auto colon = url.find("://");
    if (colon == std::string_view::npos) return wrong(url, suggestion(url));
    const auto scheme = std::ranges::find(kSchemes, url.substr(0, colon), &Scheme::name);
    if (scheme == kSchemes.end()) {
        const auto word = url.substr(0, colon);
        const auto rest = url.substr(colon);
        if (word.contains("rtu") && word.contains("tcp"))  // "rtuovertcp"
            return wrong(url, std::string("rtu+tcp").append(rest));
        return wrong_word({}, word, rest, {}, kSchemeNames);
    }
    Target target;
    target.transport = scheme->transport;
    target.framing = scheme->framing;
    target.tcp_port = scheme->tcp_port;
    const auto rest = url.substr(colon + 3);
    return scheme->transport == model::Transport::serial
               ? parse_serial_target(std::move(target), rest)
               : parse_network_target(std::move(target), scheme->name, rest);
}

Result<ListenAddress> parse_listen(std::string_view text) {
    constexpr std::string_view kScheme = "tcp://";
    constexpr std::string_view kTlsScheme = "tls://";
    ListenAddress address;
    if (text.starts_with(kScheme)) {
        text.remove_prefix(kScheme.size());
    } else if (text.starts_with(kTlsScheme)) {
        text.remove_prefix(kTlsScheme.size());
        address.certificates = take_certificates(text);
        address.port = kTlsPort;
    }
    if (text.find("://") != std::string_view::npos) return wrong(text, "127.0.0.1:502");
    TAKT_TRY(const HostPort given, split_host_port(text, 0));
    if (given.port) address.port = *given.port;
    in_addr ipv4{};
    if (given.host.empty() || given.host == "*") {
        if (!given.port) return wrong(text, "*:502");
        return address;
    }
    address.host = given.host == "localhost" ? "127.0.0.1" : given.host;
    if (inet_pton(AF_INET, address.host.c_str(), &ipv4) != 1 && !is_ipv6(given.host))
        return wrong(given.host, "127.0.0.1:502, [::1]:502, *:502");
    return address;
}

}  // namespace takt::line
