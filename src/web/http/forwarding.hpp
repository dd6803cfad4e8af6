// Which client a request comes from, behind proxies.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "takt/base/network.hpp"

namespace takt::web {

/// The fields of a proxy. Of a list, each proxy appends its own part at the end, after a comma.
struct ForwardingFields {
    std::string_view addresses;  ///< X-Forwarded-For
    std::string_view host;       ///< X-Forwarded-Host
    std::string_view scheme;     ///< X-Forwarded-Proto
};

struct ForwardedClient {
    std::string address;  ///< of the client
    std::string host;     ///< that the client asked for; empty: its proxy does not report it
    bool tls = false;     ///< the client's connection is encrypted
};

/// The client is the rightmost address that is none of the proxies: what is to the left of it can have been
/// made up. A part that is no address ends the search; then it is the proxy that sent it.
/// @param peer     address of the socket's peer, "10.0.0.5" or "[::1]". If it is none of the proxies, it is
///                 the client, and the fields do not count
[[nodiscard]] ForwardedClient forwarded_client(std::string_view peer, const ForwardingFields& fields,
                                               std::span<const Network> proxies);

/// The key of a client for limits: as rate_owner(). A text that is no address is its own key.
[[nodiscard]] std::string limit_key(std::string_view address);

}  // namespace takt::web
