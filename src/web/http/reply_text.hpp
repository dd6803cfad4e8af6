// Answers of HTTP/1.1 as text (RFC 9112, section 4).
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace takt::web {

using ReplyFields = std::vector<std::pair<std::string_view, std::string>>;

struct ReplyHead {
    int status = 200;
    std::string_view content_type;  ///< of the body
    ReplyFields fields = {};        ///< further ones
    bool close = false;             ///< the connection ends behind it
    bool head_only = false;         ///< of a request with HEAD: the body is only measured
};

/// Head and body. An answer with status 304 has no body.
[[nodiscard]] std::string reply_text(const ReplyHead& head, std::string_view body);

/// The head of an answer whose body ends with the connection.
[[nodiscard]] std::string stream_head(std::string_view content_type, const ReplyFields& fields);

/// A reply of the connection itself, which no handler has seen: an error with a body in JSON. Ends the
/// connection.
[[nodiscard]] std::string bare_reply(int status);

/// `text` in the format gzip (RFC 1952).
[[nodiscard]] std::string gzip(std::string_view text);

}  // namespace takt::web
