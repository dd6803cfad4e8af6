#include "takt/model/target_url.hpp"

#include "takt/model/fields.hpp"

namespace takt::model {
namespace {

bool is_network(const Line& line) {
    return line.transport == Transport::tcp || line.transport == Transport::tls;
}

std::string_view scheme_of(const Line& line) {
    if (line.transport == Transport::tls) return "tls";
    if (line.transport == Transport::tcp) return line.framing == wire::Framing::rtu ? "rtu+tcp" : "tcp";
    return line.framing == wire::Framing::ascii ? "ascii" : "rtu";
}

char parity_letter(wire::Parity parity) {
    return parity == wire::Parity::none ? 'N' : parity == wire::Parity::even ? 'E' : 'O';
}

}  // namespace

std::string host_and_port(std::string_view host, std::uint16_t port) {
    const bool ipv6 = host.find(':') != std::string_view::npos;
    std::string text = ipv6 ? std::string("[").append(host).append("]") : std::string(host);
    return text.append(":").append(std::to_string(port));
}

std::string url_of(const Line& line) {
    auto url = std::string(scheme_of(line)).append("://");
    if (is_network(line)) return url.append(host_and_port(line.port, line.tcp_port));
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

}  // namespace takt::model
