#include "http/reply_text.hpp"

#include <zlib.h>

#include "takt/base/assert.hpp"

namespace takt::web {
namespace {

std::string_view phrase(int status) {
    switch (status) {
        case 200: return "OK";
        case 304: return "Not Modified";
        case 400: return "Bad Request";
        case 401: return "Unauthorized";
        case 403: return "Forbidden";
        case 404: return "Not Found";
        case 405: return "Method Not Allowed";
        case 408: return "Request Timeout";
        case 409: return "Conflict";
        case 413: return "Content Too Large";
        case 414: return "URI Too Long";
        case 415: return "Unsupported Media Type";
        case 417: return "Expectation Failed";
        case 421: return "Misdirected Request";
        case 422: return "Unprocessable Content";
        case 429: return "Too Many Requests";
        case 431: return "Request Header Fields Too Large";
        case 500: return "Internal Server Error";
        case 501: return "Not Implemented";
        case 502: return "Bad Gateway";
        case 503: return "Service Unavailable";
        case 505: return "HTTP Version Not Supported";
        default: return "Error";
    }
}

void append_field(std::string& text, std::string_view name, std::string_view value) {
    text.append(name).append(": ").append(value).append("\r\n");
}

/// Status line and fields, without the empty line.
std::string first_lines(int status, std::string_view content_type, const ReplyFields& fields) {
    std::string text = "HTTP/1.1 " + std::to_string(status) + ' ' + std::string(phrase(status)) + "\r\n";
    if (!content_type.empty()) append_field(text, "Content-Type", content_type);
    for (const auto& [name, value] : fields) append_field(text, name, value);
    return text;
}

}  // namespace

std::string reply_text(const ReplyHead& head, std::string_view body) {
    auto text = first_lines(head.status, head.content_type, head.fields);
    append_field(text, "Connection", head.close ? "close" : "keep-alive");
    const bool has_body = head.status != 304;
    if (has_body) append_field(text, "Content-Length", std::to_string(body.size()));
    text += "\r\n";
    return has_body && !head.head_only ? text.append(body) : text;
}

std::string stream_head(std::string_view content_type, const ReplyFields& fields) {
    auto text = first_lines(200, content_type, fields);
    append_field(text, "Connection", "close");
    return text + "\r\n";
}

std::string bare_reply(int status) {
    const std::string code = std::to_string(status);
    const std::string_view reason = status == 429   ? ": this address is at a limit of one visitor"
                                    : status == 503 ? ": all visitors together are at a limit"
                                                    : "";
    const std::string body = "{\"error\":{\"code\":\"http_" + code + "\",\"text\":\"" + code + ' ' +
                             std::string(phrase(status)).append(reason) + "\"}}\n";
    ReplyFields fields{{"X-Content-Type-Options", "nosniff"}, {"Cache-Control", "no-store"}};
    if (status == 429 || status == 503) fields.emplace_back("Retry-After", "1");
    return reply_text(
        {.status = status, .content_type = "application/json", .fields = std::move(fields), .close = true},
        body);
}

std::string gzip(std::string_view text) {
    constexpr int kWindowAndGzip = MAX_WBITS + 16;
    constexpr int kMemory = 8;  // zlib's default
    z_stream stream{};
    TAKT_ASSERT(deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kWindowAndGzip, kMemory,
                             Z_DEFAULT_STRATEGY) == Z_OK);
    std::string packed(deflateBound(&stream, text.size()), '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));  // zlib does not change it
    stream.avail_in = static_cast<uInt>(text.size());
    stream.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_out = static_cast<uInt>(packed.size());
    const int result = deflate(&stream, Z_FINISH);
    packed.resize(stream.total_out);
    deflateEnd(&stream);
    TAKT_ASSERT(result == Z_STREAM_END);  // the output is as long as deflateBound() asks for
    return packed;
}

}  // namespace takt::web
