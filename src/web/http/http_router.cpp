#include "http/http_router.hpp"

#include <algorithm>
#include <array>
#include <exception>
#include <utility>

#include "http/lower_ascii.hpp"
#include "http/page.hpp"
#include "takt/base/ascii.hpp"
#include "takt/base/utf8.hpp"

namespace takt::web {
namespace {

constexpr std::string_view kApi = "/api/v1";
constexpr std::size_t kLeastPacked = 1024;  // bytes of a body: smaller ones are not compressed

// Scripts and styles come from the program only; the page can neither be framed nor give its address away.
// Inline styles: uPlot and the page's virtual tables place their elements with them.
constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kFields = {{
    {"Content-Security-Policy",
     "default-src 'self'; img-src 'self' data:; style-src 'self' 'unsafe-inline'; object-src 'none'; "
     "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
    {"X-Content-Type-Options", "nosniff"},
    {"X-Frame-Options", "DENY"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Opener-Policy", "same-origin"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Permissions-Policy", "camera=(), microphone=(), geolocation=()"},
}};

ReplyFields with_common(ReplyFields fields) {
    for (const auto& [name, value] : kFields) fields.emplace_back(name, value);
    return fields;
}

bool is_api(const RequestHead& head) {
    return head.path.starts_with("/api");
}

/// Below kApi; empty for another path.
std::string_view api_path(const RequestHead& head) {
    return head.path.starts_with(kApi) ? std::string_view(head.path).substr(kApi.size()) : "";
}

std::optional<Method> method_of(std::string_view name) {
    if (name == "GET" || name == "HEAD") return Method::get;
    if (name == "POST") return Method::post;
    if (name == "PUT") return Method::put;
    return std::nullopt;
}

std::string_view allow_text(Method method) {
    return method == Method::get ? "GET, HEAD" : method == Method::post ? "POST" : "PUT";
}

/// The first part of a list, in which it is shortened: "gzip;q=0.5".
std::string_view take_part(std::string_view& list) {
    const auto part = list.substr(0, list.find(','));
    list.remove_prefix(std::min(list.size(), part.size() + 1));
    return trimmed(part, " \t");
}

/// With a quality of 0 it is not accepted (RFC 9110, 12.4.2).
bool accepts_gzip(const RequestHead& head) {
    for (auto list = head.text_of("accept-encoding"); !list.empty();) {
        const auto part = take_part(list);
        const auto coding = part.substr(0, part.find(';'));
        const auto quality = part.find("q=");
        const auto weight = quality == std::string_view::npos ? "1" : part.substr(quality + 2);
        if (lower_ascii(trimmed(coding, " \t")) == "gzip")
            return weight.find_first_not_of("0.") != std::string_view::npos;
    }
    return false;
}

/// A proxy that compresses makes the tag weak: `W/"…"`.
bool has_etag(const RequestHead& head, std::string_view etag) {
    for (auto list = head.text_of("if-none-match"); !list.empty();) {
        auto part = take_part(list);
        if (part.starts_with("W/")) part.remove_prefix(2);
        if (part == etag || part == "*") return true;
    }
    return false;
}

/// Captures are not.
bool is_text(std::string_view content_type) {
    return content_type.starts_with("text/") || content_type.starts_with("application/json") ||
           content_type == "image/svg+xml";
}

bool is_utf8(std::string_view text) {
    while (!text.empty()) {
        const auto size = first_character(text).bytes;
        if (size == 0) return false;
        text.remove_prefix(size);
    }
    return true;
}

std::string quoted_file_name(std::string name) {
    std::ranges::replace_if(
        name, [](char c) { return c == '"' || c == '\\' || static_cast<unsigned char>(c) < 0x20; }, '_');
    return '"' + name + '"';
}

HttpReply reply_of(const RequestHead& head, int status, std::string_view content_type, ReplyFields fields,
                   std::string_view body) {
    const bool close = !head.keeps_alive;
    return {.bytes = reply_text({.status = status,
                                 .content_type = content_type,
                                 .fields = with_common(std::move(fields)),
                                 .close = close,
                                 .head_only = head.method == "HEAD"},
                                body),
            .close = close};
}

HttpReply reply_of(const RequestHead& head, const ApiResponse& answer, ReplyFields fields = {}) {
    fields.emplace_back("Cache-Control", "no-store");
    if (!answer.file_name.empty())
        fields.emplace_back("Content-Disposition",
                            "attachment; filename=" + quoted_file_name(answer.file_name));
    if (answer.body.size() < kLeastPacked || !is_text(answer.content_type) || !accepts_gzip(head))
        return reply_of(head, answer.status, answer.content_type, std::move(fields), answer.body);
    fields.emplace_back("Content-Encoding", "gzip");
    return reply_of(head, answer.status, answer.content_type, std::move(fields), gzip(answer.body));
}

}  // namespace

HttpRouter::HttpRouter(GuardPolicy policy, std::vector<Network> proxies, text::Language language,
                       std::vector<ApiRoute> routes, std::vector<StreamRoute> streams, Log log)
    : guard_(std::move(policy)),
      proxies_(std::move(proxies)),
      language_(language),
      routes_(std::move(routes)),
      streams_(std::move(streams)),
      log_(log) {}

const ApiRoute* HttpRouter::route_of(const RequestHead& head) const {
    const auto found = std::ranges::find_if(routes_, [&](const ApiRoute& its) {
        return its.path == api_path(head) && its.method == method_of(head.method);
    });
    return found == routes_.end() ? nullptr : &*found;
}

const StreamRoute* HttpRouter::stream_of(const RequestHead& head) const {
    const auto found = std::ranges::find(streams_, api_path(head), &StreamRoute::path);
    return found == streams_.end() ? nullptr : &*found;
}

report::Texts HttpRouter::texts_of(const RequestHead& head) const {
    const auto parameter = head.parameter("lang");
    const auto wanted = parameter ? std::string_view(*parameter) : head.text_of("accept-language");
    return report::Texts(text::language(wanted).value_or(language_));
}

GuardedRequest HttpRouter::guarded(const RequestHead& head, const ForwardedClient& client) const {
    // The rules come first: a stranger does not learn which routes there are.
    const auto* const route = is_api(head) ? route_of(head) : nullptr;
    GuardedRequest request{.api = is_api(head),
                           .reads = method_of(head.method) == Method::get,
                           .changes = route && route->changes,
                           .tls = client.tls,
                           .host = head.field("host"),
                           .origin = head.field("origin"),
                           .fetch_site = head.field("sec-fetch-site"),
                           .mark = head.field("x-takt"),
                           .content_type = head.field("content-type"),
                           .authorization = head.field("authorization"),
                           .query_token = head.parameter("token"),
                           .parameters = head.query.size()};
    if (!client.host.empty()) request.forwarded_host = client.host;
    for (const auto& [name, value] : head.query)
        request.longest_parameter = std::max({request.longest_parameter, name.size(), value.size()});
    return request;
}

// Visitors with the token have limits of their own: behind a proxy that is not named all have one address,
// and those without a token must not use up the limits of the others.
std::optional<HttpReply> HttpRouter::admit(HttpRequest& request) const {
    const auto& head = request.head;
    const auto client = forwarded_client(request.peer,
                                         {head.text_of("x-forwarded-for"), head.text_of("x-forwarded-host"),
                                          head.text_of("x-forwarded-proto")},
                                         proxies_);
    const auto checked = guarded(head, client);
    request.client = client.address;
    request.visitor = limit_key(client.address) + (guard_.has_token(checked) ? " token" : "");
    if (const auto why = guard_.check(checked)) {
        if (head.body_bytes > 0) request.head.keeps_alive = false;  // its body is not received
        ReplyFields fields;
        if (why->status == 401) fields.emplace_back("WWW-Authenticate", "Bearer");
        return refuse(head, *why, std::move(fields));
    }
    request.is_stream = head.method == "GET" && stream_of(head);
    if (const auto* const route = route_of(head)) {
        request.work = route->work;
        if (route->newest_only)
            request.superseded_by = client.address + ' ' + head.parameter("client").value_or("");
    }
    return std::nullopt;
}

HttpReply HttpRouter::reply(HttpRequest request) const {
    return is_api(request.head) ? serve_api(std::move(request)) : serve_page(request.head);
}

HttpReply HttpRouter::refuse(const RequestHead& head, const Refusal& why, ReplyFields fields) const {
    const auto text = texts_of(head)("web.error." + std::string(why.code));
    return reply_of(head, ApiResponse::error(why.status, why.code, text), std::move(fields));
}

HttpReply HttpRouter::serve_page(const RequestHead& head) const {
    const auto* const file = find_page_file(head.path == "/index.html" ? "/" : head.path);
    if (!file) return refuse(head, {404, "not_found"});
    if (method_of(head.method) != Method::get)
        return refuse(head, {405, "method"}, {{"Allow", std::string(allow_text(Method::get))}});
    ReplyFields fields{
        {"ETag", std::string(file->etag)}, {"Cache-Control", "no-cache"}, {"Vary", "Accept-Encoding"}};
    if (has_etag(head, file->etag)) return reply_of(head, 304, "", std::move(fields), "");
    const bool packed = accepts_gzip(head);
    if (packed) fields.emplace_back("Content-Encoding", "gzip");
    return reply_of(head, 200, file->content_type, std::move(fields), packed ? file->gzip : file->plain);
}

HttpReply HttpRouter::serve_api(HttpRequest request) const {
    const auto& head = request.head;
    const auto texts = texts_of(head);
    ApiRequest asked{
        .body = std::move(request.body), .texts = texts, .peer = request.client, .stop = request.stop};
    for (const auto& [name, value] : head.query)
        if (name != "token") asked.query.emplace(name, value);
    if (const auto* const route = route_of(head)) return reply_of(head, execute(*route, asked));
    const auto* const stream = stream_of(head);
    if (stream && head.method == "GET") {
        auto source = stream->open(asked);
        if (!source) return refuse(head, {503, "streams"}, {{"Retry-After", "5"}});
        return {.bytes = stream_head("text/event-stream", with_common({{"Cache-Control", "no-store"},
                                                                       {"X-Accel-Buffering", "no"}})),
                .stream = std::move(source)};
    }
    std::string allowed = stream ? "GET" : "";
    for (const auto& route : routes_)
        if (route.path == api_path(head))
            allowed.append(allowed.empty() ? "" : ", ").append(allow_text(route.method));
    if (allowed.empty()) return refuse(head, {404, "not_found"});
    return refuse(head, {405, "method"}, {{"Allow", allowed}});
}

ApiResponse HttpRouter::execute(const ApiRoute& route, const ApiRequest& request) const {
    try {
        if (!is_utf8(request.body)) return ApiResponse::error(400, "utf8", request.texts("web.error.utf8"));
        return route.handler(request);
    } catch (const std::exception& failure) {
        log_(LogLevel::error, "web.handler_failed", failure.what());
        return ApiResponse::error(500, "internal", request.texts("web.error.internal"));
    }
}

}  // namespace takt::web
