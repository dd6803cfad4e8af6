// Where a request of HTTP/1.1 ends in a stream of bytes (RFC 9112, sections 2.2, 3, 5 and 6).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace takt::web {

struct FramingLimits {
    std::size_t head_bytes = 16 << 10;   ///< request line and fields
    std::size_t target_bytes = 4 << 10;  ///< of the request line
    std::size_t fields = 64;             ///< lines of fields
    std::size_t body_bytes = 16 << 20;
};

/// The head of a request, reduced to what the program uses.
struct RequestHead {
    /// Request line and the known fields, as on the wire, with the empty line. Fields with an effect on
    /// framing, ranges and codings are left out, so that nothing behind can interpret them otherwise.
    std::string text;
    std::size_t body_bytes = 0;
    bool expects_continue = false;  ///< the client waits for status 100 before it sends the body
};

/// The size of the head with its empty line; nothing: not all of it is there.
/// @param from  bytes that were there in the last call
[[nodiscard]] std::optional<std::size_t> head_size(std::string_view bytes, std::size_t from = 0);

/// A head, or the status of the answer to a request that is rejected.
struct ParsedHead {
    RequestHead head;
    int status = 0;  ///< 0: accepted; else 400, 411, 413, 414, 431, 501 or 505
};

/// Strict: line ends are CRLF, no control characters, no folded lines, a field that decides is there once.
/// Transfer codings are rejected: browsers and the program's clients send a Content-Length.
/// @param head  with its empty line
[[nodiscard]] ParsedHead parse_head(std::string_view head, const FramingLimits& limits = {});

}  // namespace takt::web
