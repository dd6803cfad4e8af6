// The head of a request of HTTP/1.1: where it ends in a stream of bytes, and what it asks for (RFC 9112,
// sections 2.2, 3, 5 and 6).
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace takt::web {

struct HeadLimits {
    std::size_t head_bytes = 16 << 10;   ///< request line and fields
    std::size_t target_bytes = 4 << 10;  ///< of the request line
    std::size_t fields = 64;             ///< lines of fields
    std::size_t body_bytes = 16 << 20;
};

/// The head of a request, reduced to what the program uses.
struct RequestHead {
    std::string method;  ///< "GET"
    std::string path;    ///< of the target, decoded: "/api/v1/status"
    std::multimap<std::string, std::string, std::less<>> query = {};  ///< decoded, `+` is a blank
    /// The known ones, with names in lower case. Lines of proxies are joined by ", ".
    std::map<std::string, std::string, std::less<>> fields = {};
    std::size_t body_bytes = 0;
    bool expects_continue = false;  ///< the client waits for status 100 before it sends the body
    bool keeps_alive = true;        ///< the client may send another request on this connection

    /// @param name  in lower case. @returns nothing: it is not there
    [[nodiscard]] std::optional<std::string> field(std::string_view name) const;
    /// @returns empty: it is not there
    [[nodiscard]] std::string_view text_of(std::string_view name) const;
    /// The first value of a parameter of the query.
    [[nodiscard]] std::optional<std::string> parameter(std::string_view name) const;
};

/// The size of the head with its empty line; nothing: not all of it is there.
/// @param from  bytes that were there in the last call
[[nodiscard]] std::optional<std::size_t> head_size(std::string_view bytes, std::size_t from = 0);

/// A head, or the status of the answer to a request that is rejected.
struct ParsedHead {
    RequestHead head;
    int status = 0;  ///< 0: accepted; else 400, 413, 414, 415, 417, 431, 501 or 505
};

/// Strict: line ends are CRLF, no control characters, no folded lines, `%` begins a code, a field that
/// decides is there once. Transfer codings are rejected: browsers and the program's clients send a
/// Content-Length.
/// @param head  with its empty line
[[nodiscard]] ParsedHead parse_head(std::string_view head, const HeadLimits& limits = {});

}  // namespace takt::web
