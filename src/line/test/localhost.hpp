// Whether the machine can resolve `localhost`: tests that need the name are skipped elsewhere.
#pragma once

#include <netdb.h>
#include <sys/socket.h>

namespace takt::line {

inline constexpr const char* kNoLocalhost =
    "skipped: this machine does not resolve `localhost` to an IPv4 address (see /etc/hosts)";

inline bool localhost_resolves() {
    const addrinfo hints{.ai_family = AF_INET, .ai_socktype = SOCK_STREAM};
    addrinfo* found = nullptr;
    if (getaddrinfo("localhost", nullptr, &hints, &found) != 0) return false;
    freeaddrinfo(found);
    return true;
}

}  // namespace takt::line
