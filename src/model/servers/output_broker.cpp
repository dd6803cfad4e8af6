// Brokers of an output: mqtts://broker.example:8883.
#include <algorithm>
#include <array>
#include <expected>
#include <utility>

#include "servers/interpretation.hpp"
#include "servers/output_parts.hpp"
#include "takt/base/ascii.hpp"
#include "takt/base/network.hpp"
#include "takt/model/nearest.hpp"
#include "takt/model/target_url.hpp"

namespace takt::model {
namespace {

constexpr std::size_t kMostBrokers = 8;
constexpr std::uint16_t kPort = 1883;
constexpr std::uint16_t kMqttTlsPort = 8883;
constexpr std::uint64_t kLastPort = 65535;
constexpr std::size_t kLongestUrl = 300;
constexpr std::string_view kBrokerUrlForms =
    "mqtts://HOST, mqtts://HOST:8883, mqtt://192.168.1.5, mqtt://[::1]:1883";

/// What a text without, or with another scheme means.
constexpr std::pair<std::string_view, bool> kSchemes[] = {
    {"mqtt", false}, {"mqtts", true}, {"tcp", false}, {"ssl", true}, {"tls", true}};

struct BrokerFailure {
    Rule rule{};
    std::string meant;  // empty: unknown
};

bool is_host(std::string_view host) {
    if (host.empty()) return false;
    const bool numeric = host.find_first_not_of("0123456789.") == std::string_view::npos;
    if (numeric || host.find(':') != std::string_view::npos) return parse_ip(host).has_value();
    return std::ranges::all_of(host, [](char c) {
        return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' || c == '-' ||
               c == '_' || static_cast<unsigned char>(c) >= 0x80;
    });
}

std::optional<std::uint16_t> parse_port(std::string_view text) {
    const auto number = parse_integer(text);
    if (!number || number->negative || number->magnitude < 1 || number->magnitude > kLastPort)
        return std::nullopt;
    return static_cast<std::uint16_t>(number->magnitude);
}

std::expected<Broker, BrokerFailure> parse_authority(std::string_view text, bool tls) {
    Broker broker{.port = tls ? kMqttTlsPort : kPort, .tls = tls};
    const BrokerFailure malformed{Rule::output_broker_malformed, {}};
    const bool brackets = text.starts_with('[');
    const auto host_end = brackets ? text.find(']') : std::min(text.find(':'), text.size());
    if (host_end == std::string_view::npos) return std::unexpected(malformed);
    broker.host = text.substr(brackets ? 1 : 0, host_end - (brackets ? 1 : 0));
    const auto rest = text.substr(brackets ? host_end + 1 : host_end);
    if (!is_host(broker.host) || (brackets && broker.host.find(':') == std::string::npos))
        return std::unexpected(malformed);
    if (rest.empty()) return broker;
    const auto port = rest.starts_with(':') ? parse_port(rest.substr(1)) : std::nullopt;
    if (!port) return std::unexpected(malformed);
    broker.port = *port;
    return broker;
}

std::expected<Broker, BrokerFailure> parse_broker(std::string_view text) {
    constexpr std::string_view kSeparator = "://";
    const auto scheme_end = text.find(kSeparator);
    const auto scheme = text.substr(0, scheme_end == std::string_view::npos ? 0 : scheme_end);
    auto authority = scheme.empty() ? text : text.substr(scheme_end + kSeparator.size());
    const auto at = authority.rfind('@');
    if (at != std::string_view::npos) authority.remove_prefix(at + 1);
    if (authority.ends_with('/')) authority.remove_suffix(1);
    const auto* const known = std::ranges::find(kSchemes, scheme, &std::pair<std::string_view, bool>::first);
    const bool right = known != std::end(kSchemes) && known - std::begin(kSchemes) < 2;
    // Without a scheme the port says which one is meant. The secure form of another one ends with s: https.
    const bool tls = known != std::end(kSchemes) ? known->second
                     : scheme.empty()            ? authority.ends_with(":8883")
                                                 : scheme.size() > 2 && scheme.ends_with('s');
    auto meant = parse_authority(authority, tls);
    if (right && at == std::string_view::npos) return meant;
    if (at == std::string_view::npos && !meant && scheme.empty()) return meant;
    return std::unexpected(
        BrokerFailure{at != std::string_view::npos ? Rule::output_broker_user : Rule::output_broker_scheme,
                      meant ? url_of(*meant) : std::string()});
}

/// A URL with a password is not shown.
std::string without_password(std::string_view text) {
    const auto at = text.rfind('@');
    if (at == std::string_view::npos) return std::string(text);
    const auto scheme = text.find("://");
    return std::string(text.substr(0, scheme == std::string_view::npos ? 0 : scheme + 3))
        .append("***")
        .append(text.substr(at));
}

}  // namespace

std::string url_of(const Broker& broker) {
    return std::string(broker.tls ? "mqtts://" : "mqtt://").append(host_and_port(broker.host, broker.port));
}

bool is_this_computer(std::string_view host) {
    return host == "localhost" || host == "::1" || (host.starts_with("127.") && parse_ip(host));
}

std::vector<Broker> read_brokers(Interpretation& state, Reader& reader) {
    std::vector<Broker> brokers;
    if (!reader.given("brokers") && !reader.misspelt("brokers"))
        reader.report(reader.node().find("brokers") != nullptr ? Rule::field_empty : Rule::field_missing,
                      "brokers", std::string(kBrokerUrlForms), {{"key", "brokers"}});
    const Node* const list = reader.list("brokers");
    if (list == nullptr) return brokers;
    if (list->items.empty()) reader.report(Rule::field_empty, "brokers", {}, {{"key", "brokers"}});
    if (list->items.size() > kMostBrokers)
        reader.report(Rule::output_many_brokers, "brokers", "1.." + std::to_string(kMostBrokers),
                      {{"count", std::to_string(list->items.size())}});
    for (std::size_t i = 0; i < std::min(list->items.size(), kMostBrokers); ++i) {
        const auto& item = list->items[i];
        const auto path = reader.path_of("brokers") + "[" + std::to_string(i) + "]";
        const auto report = [&](Rule rule, const std::string& meant) {
            state.findings.add(rule, item.location, path, without_password(item.text),
                               std::string(kBrokerUrlForms),
                               {{"meant", meant.empty() ? "mqtts://broker.example:8883" : meant}});
        };
        const bool text = item.kind == Node::Kind::scalar && item.text.size() <= kLongestUrl;
        const auto broker = text ? parse_broker(item.text)
                                 : std::unexpected(BrokerFailure{Rule::output_broker_malformed, {}});
        if (!broker)
            report(broker.error().rule, broker.error().meant);
        else if (std::ranges::find(brokers, *broker) != brokers.end())
            report(Rule::output_broker_twice, {});
        else
            brokers.push_back(*broker);
    }
    return brokers;
}

}  // namespace takt::model
